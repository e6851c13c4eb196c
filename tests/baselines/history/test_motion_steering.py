import math

import numpy as np
import pytest

from reflexarc_baselines.baseline import Floats
from reflexarc_baselines.history.motion_steering import Detectors, memory_of, wired, wish
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.errors import UsageError

EYE = RetinaSpec(rays=8, fov_rad=math.radians(160.0))
"""Rays to ±10°, ±30°, ±50° and ±70°."""

PAIR = Detectors(
    bearings_rad=(math.radians(40.0),),
    separations_rad=(math.radians(20.0),),
    weights=(1.0,),
    tau_s=0.1 / math.log(2.0),  # β = 1/2
    mean_s=0.1 / math.log(4.0 / 3.0),  # β = 3/4
    dead_band=0.1,
    saturation=0.5,
)
"""Receptors at 30° and 50°, on rays of their own: 5 and 6 on the right, 2 and 1 on the left."""


def wishes(seen: list[Floats], detectors: Detectors = PAIR) -> list[float]:
    wiring = wired([detectors], EYE, period_s=0.1)
    memories = np.zeros((1, 1, memory_of(EYE).size), np.float32)
    found = []
    for rays in seen:
        turn, memories = wish(wiring, rays[np.newaxis, np.newaxis], memories)
        found.append(float(turn[0, 0]))
    return found


def lit(*rays: int, level: float = 1.0) -> Floats:
    seen = np.zeros(8, np.float32)
    seen[list(rays)] = level
    return seen


def test_an_edge_that_moves_outward_on_the_right_turns_left_as_by_hand() -> None:
    """Ray 5 lights up, then ray 6 does.

    μ₅ = 1/4, s₅ = 3/4, s̄₅ = 3/8; then μ₅ = 7/16, s₅ = 9/16, s̄₅ = 15/32 and s₆ = 3/4, s̄₆ = 3/8:
    m = 15/32 · 3/4 − 9/16 · 3/8 = 9/64, and T = (9/64) / (1/2 + 9/64) = 9/41.
    """
    found = wishes([lit(), lit(5), lit(5, 6)])
    assert found == pytest.approx([0.0, 0.0, 9.0 / 41.0], abs=1e-6)


def test_the_mirrored_scene_gives_the_opposite_turn_and_a_negative_weight_too() -> None:
    scene = list(np.random.default_rng(3).random((9, 8), np.float32))
    negative = Detectors(**{**vars(PAIR), "weights": (-1.0,)})
    forward = np.array(wishes(scene))
    assert np.abs(forward[2:]).min() > 1e-4
    assert wishes([each[::-1] for each in scene]) == pytest.approx(-forward, abs=1e-6)
    assert wishes(scene, negative) == pytest.approx(-forward, abs=1e-6)


def test_the_first_look_is_only_remembered_and_a_scene_that_stays_is_no_motion() -> None:
    assert wishes([lit(5), lit(5), lit(5)]) == [0.0, 0.0, 0.0]


def test_brightness_itself_does_not_count_from_the_first_look_on() -> None:
    dark, bright = ([lit() + k, lit(5) + k, lit(5, 6) + k] for k in (np.float32(0), np.float32(7)))
    assert wishes(bright) == pytest.approx(wishes(dark), abs=1e-5)


def test_flicker_of_everything_is_no_motion() -> None:
    levels = (0.0, 1.0, 0.2, 0.9, 0.1)
    found = wishes([np.full(8, level, np.float32) for level in levels])
    assert found == pytest.approx([0.0] * 5, abs=1e-7)


def test_many_genomes_at_once_are_each_alone() -> None:
    generator = np.random.default_rng(5)
    sets = [Detectors(**{**vars(PAIR), "weights": (w,), "tau_s": 0.1 + w}) for w in (0.5, 0.9)]
    rays = generator.random((2, 3, 8), np.float32)
    memories = generator.random((2, 3, 17), np.float32)
    together, following = wish(wired(sets, EYE, 0.1), rays, memories)
    for g, alone in enumerate(sets):
        turn, later = wish(wired([alone], EYE, 0.1), rays[g : g + 1], memories[g : g + 1])
        assert (turn[0] == together[g]).all()
        assert (later[0] == following[g]).all()


def test_lists_of_different_lengths_are_refused() -> None:
    with pytest.raises(UsageError, match="as many of each"):
        Detectors(**{**vars(PAIR), "weights": (1.0, 2.0)})
