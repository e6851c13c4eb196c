"""Files of before, which told times in steps."""

import hashlib

import numpy as np
import pytest

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import WorldError
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.files import WorldFamily, parse_world, world_named
from reflexarc_sim_bridge.worlds.seeds import test_seeds
from reflexarc_sim_bridge.worlds.world import Chassis, Senses, World, WorldSource

HEAD = 'name = "x"\n[[layers]]\nkind = "scatter"\n'
SENSES = "[senses]\nlatency_steps = 7\ngap_steps = 5\n"
FORMER = {
    "coarse": f"{HEAD}{SENSES}[chassis]\nslip = 0.3\n",
    "fine": f"dt_s = 0.03\n{HEAD}{SENSES}[chassis]\nslip = 0.3\n",
    "family": f"dt_s = {{ from = 0.03, to = 0.2 }}\n{HEAD}"
    "[senses]\nlatency_steps = 7\ngap_steps = { from = 1, to = 9 }\n"
    "[chassis]\nslip = { from = 0.1, to = 0.3 }\n",
}
RECORDED = {
    "late": "0ebb520b158bd8c0",
    "slippery": "ee1a690aa353ca3a",
    "randomised": "bfacc487649803ca",
    "street": "cf47c3dd11629ea9",
    "coarse": "f06259ec168cd508",
    "fine": "a5902ebb991191e7",
    "family": "e626d9aafbeaf98c",
}
"""What `drive_of` gave when times were steps. A change here makes other worlds of old texts."""


def drive_of(world: WorldSource) -> str:
    """Retinas, contacts and places, to a µm, of a random drive."""
    simulation = Simulation(world, PolicyContract(), test_seeds(16))
    generator, said = np.random.default_rng(5), hashlib.sha256()
    for _ in range(100):
        said.update(simulation.sense().tobytes())
        said.update(simulation.step(generator.integers(0, 3, 16)).tobytes())
        said.update(np.round([simulation.x_m, simulation.y_m], 6).tobytes())
    return said.hexdigest()[:16]


@pytest.mark.parametrize("name", RECORDED)
def test_worlds_of_before_are_driven_as_they_always_were(name: str) -> None:
    world = parse_world(FORMER[name]) if name in FORMER else world_named(name)
    assert drive_of(world) == RECORDED[name]


def test_steps_are_those_of_the_file() -> None:
    fine = parse_world('name = "x"\ndt_s = 0.02\nsenses = { latency_steps = 5, gap_steps = 10 }')
    assert fine == World("x", senses=Senses(latency_s=5 * 0.02, gap_s=10 * 0.02), dt_s=0.02)
    plain = parse_world('name = "x"\nsenses = { latency_steps = 3, noise = 0.1 }')
    assert plain == World("x", senses=Senses(noise=0.1, latency_s=0.1 + 0.1 + 0.1))
    late = 'name = "x"\nsenses = { latency_s = 0.3 }'
    assert parse_world(late).drawn(0).latency_steps == plain.drawn(0).latency_steps


def test_a_retina_at_every_step_is_one_at_every_step_whatever_it_lasts() -> None:
    assert parse_world('name = "x"\nsenses = { gap_steps = 1, latency_steps = 0 }') == World("x")


def test_slip_without_a_time_is_told_for_the_steps_of_the_file() -> None:
    for dt_s in (0.02, 0.1, 0.5):
        world = parse_world(f'name = "x"\ndt_s = {dt_s}\nchassis.slip = 0.2')
        assert world == World("x", chassis=Chassis(slip=0.2, slip_over_s=dt_s), dt_s=dt_s)
    told = parse_world('name = "x"\ndt_s = 0.02\nchassis = { slip = 0.2, slip_over_s = 0.1 }')
    assert told == World("x", chassis=Chassis(slip=0.2), dt_s=0.02)


def test_every_seed_draws_steps_as_before() -> None:
    family = parse_world(FORMER["family"])
    assert isinstance(family, WorldFamily)
    worlds = [family.drawn(seed) for seed in range(200)]
    assert {world.latency_steps for world in worlds} == {7}
    assert {world.gap_steps for world in worlds} == set(range(1, 10))
    assert family.ranges["senses.gap_steps"] == (1, 9)


@pytest.mark.parametrize(
    ("lines", "reason"),
    [
        ("senses.latency_steps = 65", r":2: senses\.latency_steps: expected 0 to 64, got 65"),
        ("senses.latency_steps = 0.5", r":2: senses\.latency_steps: expected a whole number"),
        ("senses.gap_steps = 0", r":2: senses\.gap_steps: expected 1 to 64, got 0"),
        ("senses.gap_steps = 1\nsenses.gap_s = 0.1", r":2: .*: expected gap_s alone.*got both"),
        ("senses.gap_steps = 2\ndt_s = 0.0", r":3: dt_s: expected in \(0, 10\] s, got 0\.0"),
        ("senses.gap_steps = 2\ndt_s = nan", r":3: dt_s: expected in \(0, 10\] s, got nan"),
        ("senses = 3", r":2: senses: expected a table"),
        ("chassis.slip = true", r":2: chassis\.slip: expected a number"),
        ("senses.latency_s = 200\n", r":2: senses\.latency_s: expected at most 102\.4 s, 1024 st"),
        (
            "senses.latency_s = 0.3\ndt_s = { from = 0.05, to = 0.1 }",
            r":2: senses\.latency_s: expected as many steps for every seed, got 3 to 6; give dt_s",
        ),
    ],
)
def test_what_cannot_be_is_refused_by_line_and_field(lines: str, reason: str) -> None:
    with pytest.raises(WorldError, match=reason):
        parse_world(f'name = "x"\n{lines}', "x.toml")
