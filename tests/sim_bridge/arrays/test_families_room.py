"""A family makes room for any of its worlds, whichever numbers a seed draws."""

import numpy as np
import numpy.typing as npt
import pytest

from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.files import parse_world
from reflexarc_sim_bridge.worlds.layers import CHUNK_M, chunks_across, telling_widths_m
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from reflexarc_sim_bridge.worlds.world import WorldSource

SEEDS = np.arange(40, dtype=np.uint64)

HEAD = """
name = "drawn"
width_m = WIDTH
edges = "EDGES"
[[layers]]
"""
SCATTER = """
kind = "scatter"
density_per_m2 = { from = 0.05, to = 0.4 }
"""
SHAPES = {
    "turned at the lower end": 'kind = "rectangles"\nturned_rad = [{ from = -0.6, to = 0.0 }, 0.0]',
    "larger and larger": 'kind = "discs"\nradius_m = [0.1, { from = 0.1, to = 0.9 }]',
    "with more corners": 'kind = "polygons"\ncorners = [3, { from = 3, to = 20 }]',
}
SHAPED = {name: f"{SCATTER}[[layers.shapes]]\n{shape}\n" for name, shape in SHAPES.items()}
LAYERS = {
    **SHAPED,
    "faster at the lower end": f"""{SCATTER}
motion = {{ kind = "drift", ahead_mps = {{ from = -20.0, to = -1.0 }} }}""",
    "faster at the lower end than at the upper one": f"""{SCATTER}
motion = {{ kind = "drift", left_mps = {{ from = -30.0, to = 9.0 }} }}""",
    "fast where the period is short": f"""{SCATTER}
motion = {{ kind = "swing", left_m = 20.0, period_s = {{ from = 0.5, to = 40.0 }} }}""",
    "steep where the waves are short": """
kind = "corridor"
meander_m = 4.0
wavelength_m = { from = 10.0, to = 60.0 }""",
    "automata": """
kind = "automaton"
cells_per_chunk = { from = 2, to = 16 }""",
    "gates": """
kind = "gates"
pitch_m = { from = 2.5, to = 5.0 }
opening_m = [0.5, 0.7]""",
}
WIDTHS = {
    "one width": "20.0",
    "few chunks or many": "{ from = 3.0, to = 24.0 }",
    "chunks of any width": "{ from = 2.6, to = 3.9 }",
}


def family_of(layer: str, width: str, edges: str) -> WorldSource:
    return parse_world(HEAD.replace("WIDTH", width).replace("EDGES", edges) + layer)


def rooms(simulation: Simulation) -> dict[str, int]:
    """Columns of an agent's lists."""
    agents = simulation.params.agents
    lists = "boxes", "turned", "discs", "sides", "belt_places", "belt_sizes", "belt_counts"
    return {name: getattr(agents, name).shape[-1] for name in lists}


def assert_room_for_all(family: WorldSource) -> None:
    together = Simulation(family, reference_contract(), SEEDS)
    room, has_belt = rooms(together), together.params.world.layers["has_belt"]
    for agent, seed in enumerate(SEEDS.tolist()):
        alone = Simulation(family.drawn(seed), reference_contract(), SEEDS[seed : seed + 1])
        for name, needed in rooms(alone).items():
            if not name.startswith("belt") or has_belt[agent].any():
                assert room[name] >= needed, f"{name}, seed {seed}"


@pytest.mark.parametrize("width", WIDTHS.values(), ids=WIDTHS)
@pytest.mark.parametrize("layer", LAYERS.values(), ids=LAYERS)
def test_a_family_has_as_much_room_as_any_of_its_worlds_makes(layer: str, width: str) -> None:
    edges = "unbounded" if "corridor" in layer else "periodic"
    assert_room_for_all(family_of(layer, width, edges))


@pytest.mark.parametrize("layer", SHAPED.values(), ids=SHAPED)
def test_between_open_sides_too(layer: str) -> None:
    assert_room_for_all(family_of(layer, "{ from = 4.0, to = 12.0 }", "open"))


@pytest.mark.parametrize("low_m", [1.0, 1.25, 2.5, 3.0, 3.75, 4.0, 6.25, 7.3, 20.0])
@pytest.mark.parametrize("length_m", [0.0, 0.5, 1.0, 3.0, 30.0])
def test_no_width_in_a_range_has_wider_or_narrower_chunks_than_those_that_tell(
    low_m: float, length_m: float
) -> None:
    telling_m = chunks_m(np.array(telling_widths_m(low_m, low_m + length_m)))
    any_m = chunks_m(np.linspace(low_m, low_m + length_m, 10_001))
    assert telling_m.min() <= any_m.min()
    assert telling_m.max() >= any_m.max()
    assert telling_m.max() <= 1.5 * CHUNK_M


def chunks_m(widths_m: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    return np.array([width_m / chunks_across(width_m) for width_m in widths_m.tolist()])
