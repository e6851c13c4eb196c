import math

import numpy as np
import pytest

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.contract.motion import Action
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.layers import Gates, Scatter
from reflexarc_sim_bridge.worlds.seeds import test_seeds
from reflexarc_sim_bridge.worlds.shapes import Curves, Discs, Polygons, Rectangles
from reflexarc_sim_bridge.worlds.world import Chassis, World

FAST = PolicyContract(
    retina=RetinaSpec(rays=1, range_m=0.5),
    actions=(Action("stay", 5.0, 0.0), Action("also", 5.0, 0.0)),
)
FAMILIES = {
    "rectangles": (Rectangles(),),
    "turned": (Rectangles(turned_rad=(0.0, math.pi)),),
    "askew": (Rectangles(turned_rad=(0.2, 0.9)),),
    "discs": (Discs(),),
    "polygons": (Polygons(),),
    "stars": (Polygons(corners=(5, 9), dent=(0.2, 0.6)),),
    "curves": (Curves(),),
    "mixed": (Rectangles(share=2.0), Discs(), Curves()),
}


def blind_rate(world: World, agents: int, steps: int) -> tuple[float, float]:
    """Contacts per 100 m of agents that never steer, and its standard error."""
    simulation = Simulation(world, FAST, test_seeds(agents))
    for _ in range(steps):
        simulation.step(np.zeros(agents, np.int64))
    contacts = int(simulation.contacts.sum())
    rate = 100.0 * contacts / float(simulation.distance_m.sum())
    return rate, rate / math.sqrt(contacts)


@pytest.mark.parametrize("radius_m", [0.0, 0.3])
@pytest.mark.parametrize("family", FAMILIES)
def test_a_blind_agent_meets_two_rho_r_obstacles_a_metre(family: str, radius_m: float) -> None:
    # In a wide world: beside the disc just met its wider part is met again by some, 0.2 % here.
    layer = Scatter(density_per_m2=0.2, shapes=FAMILIES[family])
    chassis = Chassis(radius_m=radius_m)
    world = World("wide", width_m=400.0, layers=(layer,), chassis=chassis)
    expected = world.blind_contacts_per_100m
    assert expected is not None
    rate, error = blind_rate(world, 512, 240)
    assert error < 0.013 * expected
    assert rate == pytest.approx(expected, abs=3.5 * error + 0.002 * expected)


def test_rectangles_have_no_excess_in_a_narrow_world() -> None:
    rate, error = blind_rate(World("reference"), 1024, 300)
    assert rate == pytest.approx(36.0, abs=3.5 * error)


def test_discs_twenty_metres_wide_have_the_excess_that_is_written_down() -> None:
    """A place beside the disc just met, at random among the free, meets it again.

    Met at a lateral offset b, uniform in ±r, it still fills 2(r − |b|) of a free width of w(1 − c):
    on average E[r²] / E[r] / (w(1 − c)), as wide discs are met more often.
    """
    world = World("discs", layers=(Scatter(shapes=(Discs(),)),))
    free_m = 20.0 * math.exp(-0.4 * Discs().mean_area_m2)
    again = Discs().mean_area_m2 / math.pi / (Discs().mean_width_m / 2) / free_m
    assert again == pytest.approx(0.034, abs=0.001)
    rate, error = blind_rate(world, 1024, 400)
    assert error < 0.15 * 36.0 * again
    assert rate == pytest.approx(36.0 * (1.0 + again), abs=3.5 * error)


def test_a_blind_agent_runs_into_a_gate_as_often_as_it_is_closed() -> None:
    gates = Gates(spacing_m=5.0, pitch_m=5.0, opening_m=(1.0, 2.0))
    simulation = Simulation(World("gates", layers=(gates,)), FAST, test_seeds(4096))
    for _ in range(4):  # past the first wall, at 1.25 m
        simulation.step(np.zeros(4096, np.int64))
    share = simulation.contacts.mean()
    assert share == pytest.approx(1.0 - 1.5 / 5.0, abs=4 * math.sqrt(0.21 / 4096))
