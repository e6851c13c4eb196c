"""Layers of obstacles, of which a world is made: each stands still or moves as a whole.

A layer is a grid of chunks in a frame of its own. A frame that drifts keeps one velocity for ever;
one that swings goes to and fro. So the place of every obstacle is a closed form of the time.

`Layer` is the table of all kinds. A kind is one module in `worlds/kinds/`, one of the same name in
`obstacles/kinds/`, and its name in that table: everything else follows from there.
"""

from typing import TypeAlias, get_args

from reflexarc_sim_bridge.worlds.grid import CHUNK_M, chunks_across, telling_widths_m
from reflexarc_sim_bridge.worlds.kinds.automaton import Automaton
from reflexarc_sim_bridge.worlds.kinds.corridor import Corridor
from reflexarc_sim_bridge.worlds.kinds.gates import Gates
from reflexarc_sim_bridge.worlds.kinds.layer_kind import WHITE, LayerKind
from reflexarc_sim_bridge.worlds.kinds.scatter import Scatter
from reflexarc_sim_bridge.worlds.layer_motion import Drift, Motion, Swing

__all__ = [
    "CHUNK_M",
    "WHITE",
    "Automaton",
    "Corridor",
    "Drift",
    "Gates",
    "Layer",
    "Motion",
    "Scatter",
    "Swing",
    "chunks_across",
    "kind_number",
    "layer_kinds",
    "telling_widths_m",
]

Layer: TypeAlias = Scatter | Gates | Corridor | Automaton
"""Any kind of layer. Its number is its place here: new kinds go to the end."""


def layer_kinds() -> tuple[type[LayerKind], ...]:
    """All kinds, in the order of their numbers."""
    return get_args(Layer)


def kind_number(layer: LayerKind) -> int:
    """Number of a layer's kind."""
    return layer_kinds().index(type(layer))
