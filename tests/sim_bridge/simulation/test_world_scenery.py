import numpy as np
import numpy.typing as npt
import pytest

from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.simulation.world_scenery import WorldScenery
from reflexarc_sim_bridge.worlds.files import WORLDS
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from reflexarc_sim_bridge.worlds.silhouettes import Area


def corners_around(simulation: Simulation, within_m: float) -> list[npt.NDArray[np.float64]]:
    """Of every obstacle that the eye has near, the box around it, if its middle is so close."""
    here = np.array([simulation.x_m[0], simulation.y_m[0]])
    boxes = []
    for outline in simulation.outlines_near(0):
        middle = np.array([outline.x_m, outline.y_m])
        reach_m = np.array([outline.radius_m, outline.radius_m])
        low, high = middle - reach_m, middle + reach_m
        if not outline.is_disc:
            low, high = outline.corners_m.min(axis=0), outline.corners_m.max(axis=0)
        if low[0] > here[0] and np.hypot(*(middle - here)) < within_m:
            boxes.append(np.concatenate([low, high]))
    return sorted(boxes, key=tuple)


@pytest.mark.parametrize("name", ["crossing", "swing", "stars", "corridor-10", "legacy"])
def test_what_is_drawn_is_what_the_eye_meets(name: str):
    simulation = Simulation(WORLDS[name].drawn(3), reference_contract(), np.array([3], np.uint64))
    for _ in range(25):
        simulation.step(np.zeros(1, np.int64))
    simulation.sense()
    x_m, y_m, time_s = float(simulation.x_m[0]), float(simulation.y_m[0]), 2.5
    seen = corners_around(simulation, 4.0)
    drawn = WorldScenery(simulation).within(Area(x_m, x_m + 8, y_m - 8, y_m + 8), time_s)
    boxes = [np.concatenate([s.corners_m.min(axis=0), s.corners_m.max(axis=0)]) for s in drawn]
    assert len(seen) > 1
    for box in seen:
        assert min(np.abs(np.array(boxes) - box).max(axis=1)) < 5e-3
