"""Eyes whose rays are permuted or which sit askew, against plain eyes that see the same."""

import dataclasses
import math

import numpy as np
import pytest

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import BeamRule, RetinaSpec, Shading
from reflexarc_runtime.contract.motion import Action
from reflexarc_sim_bridge.arrays.eyes import eye_params, seen_behind_m
from reflexarc_sim_bridge.arrays.true_bearings import ray_order
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.files import world_named
from reflexarc_sim_bridge.worlds.seeds import test_seeds
from reflexarc_sim_bridge.worlds.world import Scanner, Senses, World
from support.slow_geometry import Floats

SEED = 5
STEPS = 12

EYES = {
    "one tile": RetinaSpec(rays=16),
    "four tiles": RetinaSpec(rays=64, fov_rad=1.2),
    "no whole tile, samples": RetinaSpec(rays=11, samples=3, beams=BeamRule.SECTOR_MINIMUM),
    "two eyes, colours": RetinaSpec(
        rays=16, eyes=2, baseline_m=0.2, channels=3, shading=Shading.COLOUR
    ),
    "narrow": RetinaSpec(rays=8, fov_rad=0.5),
    "all round": RetinaSpec(rays=32, fov_rad=2 * math.pi),
}
WORLD_NAMES = ("reference-1", "stars", "discs", "colours", "legacy")


def world(name: str, **senses: object) -> World:
    plain = world_named(name)
    assert isinstance(plain, World)
    return dataclasses.replace(plain, senses=dataclasses.replace(plain.senses, **senses))  # type: ignore[arg-type]  # by name


def looks(seen_in: World, eye: RetinaSpec, actions: tuple[Action, ...] = ()) -> Floats:
    """What 12 agents see on a way that does not depend on it: (steps, n, frames, eyes, rays, c)."""
    contract = PolicyContract(retina=eye, actions=actions or PolicyContract().actions)
    simulation, seen = Simulation(seen_in, contract, test_seeds(12)), []
    generator = np.random.default_rng(1)
    for _ in range(STEPS):
        simulation.sense()
        seen.append(simulation.stacks.astype(float))
        simulation.step(generator.integers(0, len(contract.actions), 12))
    return np.array(seen)


TURNING = (Action("stay", 1.0, 0.0), Action("left", 1.0, 0.0, 2.0), Action("right", 1.0, 0.0, -2.0))


@pytest.mark.parametrize("actions", [(), TURNING], ids=["sideways", "turning"])
@pytest.mark.parametrize("name", WORLD_NAMES)
@pytest.mark.parametrize("eye", EYES.values(), ids=EYES)
def test_a_permuted_eye_sees_what_a_plain_one_sees_in_another_order(
    eye: RetinaSpec, name: str, actions: tuple[Action, ...]
) -> None:
    if name == "colours" and eye.channels == 1:
        eye = dataclasses.replace(eye, shading=Shading.COLOUR)
    order = np.array(ray_order(eye.rays, SEED))
    plain, permuted = (looks(world(name, permuted=s), eye, actions) for s in (0, SEED))
    assert plain.any()
    np.testing.assert_array_equal(permuted, plain[..., order, :])


def test_a_permutation_is_one_and_another_for_another_seed() -> None:
    orders = {ray_order(16, seed) for seed in range(50)}
    assert len(orders) == 50
    assert all(sorted(order) == list(range(16)) for order in orders)
    assert ray_order(7, 0) == tuple(range(7))


def test_the_permutation_of_the_shipped_world_stays_what_it_is() -> None:
    permuted = world("permuted")
    expected = (7, 9, 10, 15, 4, 2, 11, 6, 14, 0, 12, 5, 1, 8, 3, 13)
    assert ray_order(16, permuted.senses.permuted) == expected


@pytest.mark.parametrize("sectors", [-3, 1, 4])
@pytest.mark.parametrize("name", ["reference-1", "stars", "discs"])
def test_an_eye_that_sits_some_sectors_askew_sees_what_a_wider_one_sees_there(
    name: str, sectors: int
) -> None:
    """Rays are counted from the left: turned to the left by k sectors, ray j is the wide j + 8 - k.

    A wide eye of 32 rays over twice the field of view has the same sectors, 8 more on either side.
    """
    narrow = RetinaSpec(rays=16, fov_rad=1.6)
    wide = looks(world(name), RetinaSpec(rays=32, fov_rad=3.2))
    askew = looks(world(name, mounted_rad=sectors * 0.1), narrow)
    expected = wide[..., 8 - sectors : 24 - sectors, :]
    assert plain_share(askew) > 0.1
    off = np.abs(askew - expected)
    assert off.max() <= 1 or (off > 1).mean() < 1e-3  # bearings differ by rounding; a ray may graze
    assert (off == 0).mean() > 0.99
    assert (askew != looks(world(name), narrow)).mean() > 0.1


def plain_share(seen: Floats) -> float:
    return float((seen > 0).mean())


def test_what_lies_beside_and_behind_is_seen_by_an_eye_that_is_turned_there() -> None:
    """All that an eye over the full circle sees, four eyes of 90° see that look to four sides."""
    round_about = looks(world("reference-1"), RetinaSpec(rays=64, fov_rad=2 * math.pi))
    quarter = RetinaSpec(rays=16, fov_rad=math.pi / 2)
    # The leftmost ray looks backwards: first the quarter behind left, then ahead left, and so on.
    for part, mounted_rad in enumerate((0.75 * math.pi, 0.25 * math.pi, -0.25 * math.pi)):
        seen = looks(world("reference-1", mounted_rad=mounted_rad), quarter)
        off = np.abs(seen - round_about[..., 16 * part : 16 * (part + 1), :])
        assert (off <= 1).mean() > 0.999


def test_how_far_behind_is_looked_is_that_of_the_hindmost_ray() -> None:
    eye = RetinaSpec(rays=2, fov_rad=2.0, range_m=4.0, beams=BeamRule.NEAREST_BEAM)  # at ±0.5
    for mounted_rad in (0.0, 1.0, 1.5, -2.0, math.pi):
        bearings = (mounted_rad + 0.5, mounted_rad - 0.5)
        expected = 4.0 * max(0.0, *(-math.cos(b) for b in bearings))
        seen_m = seen_behind_m(eye, World("x", senses=Senses(mounted_rad=mounted_rad)))
        assert seen_m == pytest.approx(expected, abs=1e-12)


def test_dead_sectors_are_bearings_on_the_body() -> None:
    eye = RetinaSpec(rays=4, fov_rad=math.pi)  # rays at 67.5°, 22.5°, -22.5° and -67.5°
    dead = ((math.radians(60.0), math.radians(75.0)),)
    order = ray_order(4, SEED)
    permuted = Senses(dead_sectors=dead, permuted=SEED)
    turned = Senses(dead_sectors=dead, mounted_rad=math.radians(45.0))
    assert alive(eye, Senses(dead_sectors=dead)) == [False, True, True, True]
    assert alive(eye, permuted) == [ray != 0 for ray in order]
    assert alive(eye, turned) == [True, False, True, True]


def alive(eye: RetinaSpec, senses: Senses) -> list[bool]:
    return eye_params(PolicyContract(retina=eye), World("x", senses=senses)).alive.tolist()


def test_a_scanner_goes_along_with_its_eye() -> None:
    eye = RetinaSpec(rays=6, fov_rad=1.2, beams=BeamRule.SECTOR_MINIMUM)
    plain = dataclasses.replace(world("reference-1"), scanner=Scanner(beams=121, sweep_rad=2.4))
    order = np.array(ray_order(6, SEED))
    mixed = dataclasses.replace(plain, senses=Senses(permuted=SEED))
    np.testing.assert_array_equal(looks(mixed, eye), looks(plain, eye)[..., order, :])
    turned = dataclasses.replace(plain, senses=Senses(mounted_rad=0.4))  # 20 beams, 2 sectors
    bearings = [
        Simulation(each, PolicyContract(retina=eye), test_seeds(1)) for each in (plain, turned)
    ]
    off_rad = bearings[1].bearings_rad - bearings[0].bearings_rad
    np.testing.assert_allclose(off_rad, 0.4)


def test_a_world_without_them_has_the_eye_that_it_always_had() -> None:
    """Equal to the last bit: what it was before these two properties came."""
    eye = RetinaSpec(rays=5, fov_rad=2.0, beams=BeamRule.NEAREST_BEAM)
    bearings = [2.0 * (0.5 - (ray + 0.5) / 5) for ray in range(5)]
    params = eye_params(PolicyContract(retina=eye), World("x"))
    assert params.ahead[:5].tolist() == np.cos(bearings).astype(np.float32).tolist()
    assert params.left[:5].tolist() == np.sin(bearings).astype(np.float32).tolist()
    assert (params.is_wide, params.tile_is_wide) == (False, False)
