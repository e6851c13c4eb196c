"""How much of a world may be looked at, so that checking any world that is allowed ends in time.

One place, or one step of an agent, costs what lies around it: in `reference-1` 143 obstacles, in a
field as dense as a file may ask for 2,000 and more, and around an agent that meets one at every
step they are drawn anew each time. Work is counted in obstacles, not in seconds, so that the same
world is measured alike on every machine. Measured on one core: an obstacle that is drawn takes some
12 ns, one that is looked at again 4 ns.

Worlds that people use stay as they are. What would take minutes is looked at in fewer places and
steps, and the errors say so.
"""

import math
from dataclasses import dataclass

import numpy as np

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_sim_bridge.arrays.world_tables import world_tables
from reflexarc_sim_bridge.worlds.grid import CHUNK_M
from reflexarc_sim_bridge.worlds.layers import Layer, Scatter
from reflexarc_sim_bridge.worlds.world import World

MOST_DRAWN = 250e6
"""Obstacles that are drawn for the places of a profile: three seconds."""
MOST_LOOKED_AT = 1450e6
"""Obstacles that are looked at in the steps of blind agents: five seconds."""

_DRAWING = 3.0
"""What drawing an obstacle costs, in looks."""
_ON_BELT = 4
"""Obstacles on a belt that are looked at for the cost of another one: they are read in vectors."""
_SIDES = 8
"""Sides of polygons are reserved for the most corners everywhere: one in so many is there."""
_CELLS = 4
"""The same of what is not scattered: cells that could be full, gates that could be near."""
_COMPARED = 3
"""Of the centres that may lie within the gap, one in so many is compared until one is found."""
_FULLEST = 0.9
"""Of a world that is covered more than that, a free place is not looked for any longer."""


@dataclass(frozen=True)
class Effort:
    """What lies around an agent, in obstacles."""

    drawn_a_column: float
    """That are drawn to look at one place in each bin across a world."""
    drawn_a_cell: float
    """That are drawn anew when an agent enters a cell, or is put elsewhere."""
    looked_at_a_step: float
    entered_a_step: float
    """Cells that an agent enters in a step."""

    def most_columns(self, seeds: int) -> float:
        """Columns of places that may be looked at for each seed."""
        return MOST_DRAWN / max(self.drawn_a_column, 1.0) / seeds

    def most_steps(self, contacts_a_step: float, cover: float) -> float:
        """Steps that all agents together may make.

        Args:
            contacts_a_step: of an agent; after each it is put at another place.
            cover: share of places that are not free, and are drawn in vain.
        """
        places = self.entered_a_step + contacts_a_step / (1.0 - min(cover, _FULLEST))
        return MOST_LOOKED_AT / (
            1.0 + self.looked_at_a_step + _DRAWING * self.drawn_a_cell * places
        )


def effort_of(world: World, contract: PolicyContract, bins: int) -> Effort:
    """What it takes an agent of a contract to look at a world, in so many places across."""
    tables = world_tables([world], contract)
    plane, rows = tables.planes[0], tables.layers[0]
    cells = min(bins, math.ceil(world.width_m / float(plane["chunk_width_m"])))
    column = cell = looks = 0.0
    for layer, row in zip(world.layers, rows, strict=False):
        if row["has_belt"]:
            boxes = _on_belt(layer, row, plane)
            column, looks = column + boxes, looks + boxes / _ON_BELT
            continue
        drawn = _drawn(layer, row)
        column, cell = column + drawn * cells, cell + drawn
        looks += _listed(row) / (1 if isinstance(layer, Scatter) else _CELLS)
    return Effort(column, cell, looks, _entered(world))


def _listed(row: np.void) -> float:
    """Obstacles in the near lists of a layer, at most."""
    return float(row["most_boxes"] + row["most_turned"] + row["most_discs"]) + float(
        row["most_sides"] / _SIDES
    )


def _drawn(layer: Layer, row: np.void) -> float:
    """Those that are drawn for them; of a thinned field with all that may lie within the gap."""
    if not isinstance(layer, Scatter) or layer.gap_m == 0.0:
        return _listed(row)
    around = 9 * CHUNK_M**2 * max(layer.section_densities_per_m2)
    return _listed(row) * (1.0 + around / _COMPARED)


def _on_belt(layer: Layer, row: np.void, plane: np.void) -> float:
    assert isinstance(layer, Scatter)
    beyond_m = float(plane["ahead_m"] + plane["behind_m"] + 2 * row["reach_m"])
    columns = math.ceil(beyond_m / CHUNK_M) + 2
    return float(layer.density_per_m2 * plane["width_m"] * columns * CHUNK_M)


def _entered(world: World) -> float:
    """Cells that an agent at 1 m/s enters in a step, or that pass it by."""
    motions = [layer.motion for layer in world.layers if layer.motion is not None]
    fastest_mps = 1.0 + max((motion.fastest_mps for motion in motions), default=0.0)
    return min(1.0, fastest_mps * world.dt_s / CHUNK_M)
