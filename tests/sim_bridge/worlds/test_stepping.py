import dataclasses
import math
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_runtime.errors import WorldError
from reflexarc_sim_bridge.worlds import stepping
from reflexarc_sim_bridge.worlds.world import Chassis, Senses, World


@pytest.mark.parametrize(
    ("time_s", "dt_s", "nearest", "within"),
    [
        (0.0, 0.1, 0, 1),
        (0.3, 0.1, 3, 3),
        (0.3, 0.02, 15, 15),
        (0.3, 0.001, 300, 300),
        (0.7, 0.1, 7, 7),
        (3 * 0.1, 0.1, 3, 3),
        (0.17, 0.1, 2, 1),
        (0.01, 0.1, 1, 1),
        (1e-12, 0.02, 1, 1),
        (0.06, 0.02, 3, 3),
        (0.055, 0.02, 3, 2),
    ],
)
def test_times_are_so_many_steps(time_s: float, dt_s: float, nearest: int, within: int) -> None:
    world = World("x", senses=Senses(latency_s=time_s, gap_s=time_s), dt_s=dt_s)
    assert (world.latency_steps, world.gap_steps) == (nearest, within)


@given(st.integers(0, 20_000), st.integers(1, 500))
def test_a_latency_is_off_by_half_a_step_at_most_and_a_gap_is_never_exceeded(
    time_ms: int, dt_ms: int
) -> None:
    exact = Fraction(time_ms, dt_ms)
    late = stepping.latency_steps(time_ms / 1000, dt_ms / 1000)
    assert abs(late - exact) <= Fraction(1, 2) or (late == 1 and 0 < exact < 1)
    assert (late == 0) == (time_ms == 0)
    assert stepping.gap_steps(time_ms / 1000, dt_ms / 1000) == max(exact.__floor__(), 1)


@pytest.mark.parametrize("dt_s", [0.1, 0.02, 0.03, 1 / 49, 10.0])
def test_slip_at_steps_of_its_own_time_is_itself_to_the_bit(dt_s: float) -> None:
    assert World("x", chassis=Chassis(slip=0.3, slip_over_s=dt_s), dt_s=dt_s).slip_per_step == 0.3


def test_slip_is_told_over_a_tenth_of_a_second() -> None:
    """Ten independent steps of 10 ms are off, on average, by a √10th of what each is off."""
    fine = World("x", chassis=Chassis(slip=0.2), dt_s=0.01)
    assert fine.slip_per_step / math.sqrt(10) == pytest.approx(0.2, rel=1e-12)


def test_a_latency_that_is_too_long_in_fine_steps_is_refused_in_one_line() -> None:
    late = World("x", senses=Senses(latency_s=20.0))
    with pytest.raises(WorldError) as refusal:
        dataclasses.replace(late, dt_s=0.001)
    assert str(refusal.value) == (
        "world.senses.latency_s: expected at most 1.024 s, 1024 steps of 0.001 s, got 20.0"
    )
    longest = World("x", senses=Senses(latency_s=1.024), dt_s=0.001)
    assert longest.latency_steps == stepping.MAX_LATENCY_STEPS


def test_every_gap_of_a_world_fits_into_the_finest_steps_of_a_body() -> None:
    longest = World("x", senses=Senses(gap_s=1000.0), dt_s=0.001)
    assert longest.gap_steps == stepping.MAX_GAP_STEPS
