import dataclasses
import math

import numpy as np
import numpy.typing as npt
import pytest

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import BeamRule, RetinaSpec, Shading
from reflexarc_sim_bridge.arrays.eyes import eye_params
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.layers import Scatter
from reflexarc_sim_bridge.worlds.seeds import test_seeds
from reflexarc_sim_bridge.worlds.shapes import Discs
from reflexarc_sim_bridge.worlds.world import Scanner, Senses, World
from support.scenes import STANDS_AT_M, scene_of
from support.slow_geometry import Floats, box

EMPTY = World("empty", layers=())


def contract(**fields: object) -> PolicyContract:
    return PolicyContract(retina=RetinaSpec(**fields))  # type: ignore[arg-type]  # by name


def empty_looks(senses: Senses, agents: int = 512, **fields: object) -> Floats:
    """What eyes in an empty world say: (agents, eyes, rays, channels)."""
    world = dataclasses.replace(EMPTY, senses=senses)
    return Simulation(world, contract(**fields), test_seeds(agents)).sense().astype(float)


def test_without_disturbances_an_empty_world_is_dark_and_a_background_shines() -> None:
    assert not empty_looks(Senses()).any()
    for background in (0.0, 0.2, 0.5, 1.0):
        for channels, samples in ((1, 1), (3, 1), (1, 4)):
            seen = empty_looks(Senses(background=background), 2, channels=channels, samples=samples)
            assert (seen == math.floor(255 * background + 0.5)).all()


def test_a_background_is_behind_what_is_met_and_fills_half_a_ray_by_half() -> None:
    x_m, y_m = STANDS_AT_M
    scene = [box(x_m + 2.0, y_m + 10.0, 1.0, 10.0)]  # the left half of what lies ahead
    senses = Senses(background=0.2)
    spec = RetinaSpec(rays=1, samples=2, shading=Shading.COLOUR, beams=BeamRule.NEAREST_BEAM)
    seen = scene_of(scene, PolicyContract(retina=spec), senses=senses).sense()
    assert seen.item() == math.floor(255 * (1.0 + 0.2) / 2 + 0.5)


@pytest.mark.parametrize("noise", [0.02, 0.1])
def test_noise_has_its_mean_and_standard_deviation_in_every_value(noise: float) -> None:
    seen = empty_looks(Senses(noise=noise, background=0.5), eyes=2, baseline_m=0.1, channels=3)
    off = seen / 255 - 128 / 255
    count = off.size
    assert off.mean() == pytest.approx(0.0, abs=4 * noise / math.sqrt(count))
    rounding = 1 / 255 / math.sqrt(12)
    assert off.std() == pytest.approx(math.hypot(noise, rounding), rel=4 / math.sqrt(2 * count))
    assert ((off / off.std()) ** 4).mean() == pytest.approx(3.0, abs=0.1)
    flat = off.reshape(512, -1)
    assert np.abs(np.corrcoef(flat.T) - np.eye(flat.shape[1])).max() < 5 / math.sqrt(512)


def test_noise_stays_within_the_scale() -> None:
    dark, bright = (empty_looks(Senses(noise=0.1, background=b)) for b in (0.0, 1.0))
    assert ((dark >= 0) & (dark < 128)).all()
    assert (dark == 0).mean() == pytest.approx(0.5, abs=0.03)
    assert (bright == 255).mean() == pytest.approx(0.5, abs=0.03)


def test_noise_and_dropout_are_drawn_anew_at_every_look() -> None:
    senses = Senses(noise=0.1, dropout=0.5, background=0.5)
    world = dataclasses.replace(EMPTY, senses=senses)
    simulation = Simulation(world, contract(), test_seeds(256))
    first, second = (simulation.sense().astype(float).ravel() for _ in range(2))
    assert abs(np.corrcoef(first, second)[0, 1]) < 4 / math.sqrt(first.size)


@pytest.mark.parametrize("channels", [1, 3])
def test_dropout_silences_whole_rays_at_its_rate(channels: int) -> None:
    seen = empty_looks(Senses(dropout=0.15, background=1.0), channels=channels, rays=32)
    silent = seen == 0
    assert (silent.all(axis=-1) == silent.any(axis=-1)).all()
    rate, count = silent[..., 0].mean(), silent[..., 0].size
    assert rate == pytest.approx(0.15, abs=4 * math.sqrt(0.15 * 0.85 / count))
    assert set(np.unique(seen)) == {0, 255}
    assert not empty_looks(Senses(dropout=1.0, background=1.0)).any()


@pytest.mark.parametrize("noise", [0.0, 0.2])
def test_dead_sectors_say_nothing_whatever_else_goes_wrong(noise: float) -> None:
    sectors = ((-0.5, 0.1), (1.2, 1.3))
    senses = Senses(dead_sectors=sectors, background=1.0, noise=noise)
    seen = empty_looks(senses, 64, rays=91, channels=3, eyes=2, baseline_m=0.1)
    bearings = math.pi * (0.5 - (np.arange(91) + 0.5) / 91)
    dead = np.any([(bearings >= low) & (bearings <= high) for low, high in sectors], axis=0)
    assert dead.sum() > 15
    assert not seen[:, :, dead].any()
    assert (seen[:, :, ~dead] > 0).mean() > 0.999
    alive = eye_params(contract(rays=91), dataclasses.replace(EMPTY, senses=senses)).alive
    np.testing.assert_array_equal(alive, ~dead)


def drive(world: World, eye: PolicyContract, steps: int) -> tuple[list[bytes], list[bytes]]:
    """Newest retinas and stacks of some agents, look by look."""
    simulation, generator = Simulation(world, eye, test_seeds(8)), np.random.default_rng(1)
    newest, stacks = [], []
    for _ in range(steps):
        newest.append(simulation.sense().tobytes())
        stacks.append(simulation.stacks.copy())
        simulation.step(generator.integers(0, 3, 8))
    return newest, [stack.tobytes() for stack in stacks]


@pytest.mark.parametrize("latency", [1, 3, 64])
def test_with_latency_agents_see_what_was_there_some_steps_ago(latency: int) -> None:
    late = World("late", senses=Senses(latency_s=0.1 * latency))
    now, then = (drive(world, contract(), 80)[0] for world in (World("now"), late))
    assert then == [now[max(0, look - latency)] for look in range(80)]
    assert len(set(now)) > 60


@pytest.mark.parametrize(("latency", "frames"), [(0, 1), (0, 3), (2, 1), (2, 3)])
def test_a_slow_sensor_sends_a_new_retina_after_one_to_so_many_steps(
    latency: int, frames: int
) -> None:
    """What it sends is what a quick one sees then; the gaps are even; a stack keeps what came."""
    steps, most, eye = 120, 4, contract(rays=64, frames=frames)
    quick = World("quick", layers=SOME, senses=Senses(latency_s=0.1 * latency))
    senses = Senses(latency_s=0.1 * latency, gap_s=0.1 * most)
    slow = dataclasses.replace(quick, senses=senses)
    every, free = looks(quick, contract(rays=64), steps)
    stacks, _ = looks(slow, eye, steps)
    gaps: list[int] = []
    for agent in free:
        came = [0]
        for step in range(1, steps):
            if (stacks[step, agent] != stacks[step - 1, agent]).any():
                came.append(step)
            recent = [came[max(0, len(came) - frames + k)] for k in range(frames)]
            np.testing.assert_array_equal(stacks[step, agent], every[recent, agent, 0])
        gaps += np.diff(came[1:]).tolist()  # a late sense shows its first retina for longer
    assert len(gaps) > 200
    assert max(gaps) == most
    shares = np.bincount(gaps, minlength=most + 1)[1:] / len(gaps)
    assert np.abs(shares - 1 / most).max() < 4 * math.sqrt(3 / 16 / len(gaps))


SOME = (Scatter(0.4, shapes=(Discs((0.1, 0.2)),)),)


def looks(
    world: World, eye: PolicyContract, steps: int
) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.int64]]:
    """Stacks of agents that go straight on: (steps, agents, frames, values); who met nothing."""
    simulation, seen = Simulation(world, eye, test_seeds(48)), []
    for _ in range(steps):
        simulation.sense()
        seen.append(simulation.stacks.reshape(48, eye.retina.frames, -1).copy())
        simulation.step(np.zeros(48, np.int64))
    return np.array(seen), np.flatnonzero(simulation.contacts == 0)


def test_after_a_contact_a_slow_sensor_looks_anew() -> None:
    """What it saw last was of another place."""
    slow = World("slow", layers=(Scatter(0.5),), senses=Senses(gap_s=6.4))
    eyes, quick = (
        Simulation(world, contract(), test_seeds(64))
        for world in (slow, dataclasses.replace(slow, senses=Senses()))
    )
    eyes.sense()
    contacts = 0
    for _ in range(30):
        met = eyes.step(np.zeros(64, np.int64))
        quick.restore(eyes.state())
        quick.params.agents.state["due"] = 0
        seen, there = eyes.sense(), quick.sense()
        np.testing.assert_array_equal(seen[met], there[met])
        assert (seen[~met] != there[~met]).any()
        contacts += int(met.sum())
    assert contacts > 10


@pytest.mark.parametrize("latency", [0, 2])
def test_a_stack_holds_the_last_retinas_oldest_first(latency: int) -> None:
    world = World("late", senses=Senses(latency_s=0.1 * latency))
    eye = contract(frames=4, channels=3, eyes=2, baseline_m=0.1)
    simulation, generator = Simulation(world, eye, test_seeds(8)), np.random.default_rng(1)
    seen = []
    for _ in range(12):
        seen.append(simulation.sense())
        frames = [seen[max(0, len(seen) - 4 + k)] for k in range(4)]
        np.testing.assert_array_equal(simulation.stacks, np.stack(frames, axis=1))
        simulation.step(generator.integers(0, 3, 8))
    plain = Simulation(World("now"), contract(channels=3, eyes=2, baseline_m=0.1), test_seeds(8))
    np.testing.assert_array_equal(plain.sense(), seen[0])


def test_an_eye_behind_a_scanner_looks_along_its_beams() -> None:
    scanner = Scanner(beams=19, sweep_rad=math.pi)
    one_beam = contract(rays=7, beams=BeamRule.NEAREST_BEAM)
    eye = eye_params(one_beam, dataclasses.replace(EMPTY, scanner=scanner))
    bearings = np.arctan2(eye.left, eye.ahead)[:7]  # filled up to a whole tile
    beams = (bearings + math.pi / 2) / (math.pi / 18)
    np.testing.assert_allclose(beams, np.round(beams), atol=1e-5)
    wanted = math.pi * (0.5 - (np.arange(7) + 0.5) / 7)
    assert np.abs(bearings - wanted).max() <= math.pi / 36 + 1e-6
