"""Compiling the world's step, part by part; what no world of a process needs is never compiled."""

from contextlib import nullcontext
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from numba.core import types

from reflexarc_sim_bridge.arrays.layout import SCATTER, Params, WorldTables
from reflexarc_sim_bridge.arrays.workspace import Parts
from reflexarc_sim_bridge.motion.placing import go_to_free_place
from reflexarc_sim_bridge.native.cache import compiling_alone, is_kept
from reflexarc_sim_bridge.native.function_pointers import address_of
from reflexarc_sim_bridge.native.helper_process import compiled_meanwhile, has_room
from reflexarc_sim_bridge.native.numba_compiler import without_garbage_collection
from reflexarc_sim_bridge.obstacles.gathering import gather_belt, gather_scatter, gather_structure
from reflexarc_sim_bridge.simulation.step import advance, cast, cover
from reflexarc_sim_bridge.simulation.step_pointer import types_held, types_stepped
from reflexarc_sim_bridge.vision.sensing import sense_agent
from reflexarc_sim_bridge.worlds.world import World, WorldSource

Motions = npt.NDArray[np.float64]


class Step(NamedTuple):
    """A step, ready to be called."""

    advance: int
    """Address of `kernel.advance`."""
    parts: Parts
    """What that calls."""


def step_for(source: WorldSource, params: Params, motions: Motions) -> Step:
    """The step of such a world, compiled unless that is done.

    Args:
        source: the world, or family of worlds.
        params: its simulation's.
        motions: linear, lateral and angular speed of each action: (actions, 3).
    """
    ways = _ways(source, params.world)
    form = _form(params), _form(motions), ways
    if form not in _steps:
        with compiling_alone("world"), without_garbage_collection():
            _steps[form] = _compile(params, motions, ways)
    return _steps[form]


def cover_for(params: Params, motions: Motions) -> int:
    """Address of `kernel.cover`, compiled unless that is done."""
    return _address_of(cover, params, motions, types.float64[:, ::1], types.boolean[::1])


def cast_for(params: Params, motions: Motions) -> int:
    """Address of `kernel.cast`, compiled unless that is done."""
    return _address_of(cast, params, motions)


def _address_of(function: Any, params: Params, motions: Motions, *more: Any) -> int:
    """Address of what takes a `Held` and arguments of such types."""
    form = function.__name__, _form(params), _form(motions)
    if form not in _others:
        arguments = types_stepped(params, motions)[0], *more
        with compiling_alone(function.__name__), without_garbage_collection():
            _others[form] = address_of(function, arguments)
    return _others[form]


def _ways(source: WorldSource, world: WorldTables) -> frozenset[str]:
    """How layers are gathered; in a family a scatter may have a belt in one world of many."""
    scattered, is_family = world.layers["kind"] == SCATTER, not isinstance(source, World)
    has_belt = world.layers["has_belt"][scattered] == 1
    needed = {
        "belt": has_belt.any() or (is_family and (world.belts > 0).any()),
        "scatter": not has_belt.all() or (is_family and scattered.any()),
        "structure": not scattered.all(),
    }
    return frozenset(way for way, is_needed in needed.items() if is_needed)


def _compile(params: Params, motions: Motions, ways: frozenset[str]) -> Step:
    on_agent = (*types_held(params), types.int64)
    is_worth_it = has_room() and not is_kept(advance)
    with compiled_meanwhile(sense_agent, on_agent) if is_worth_it else nullcontext():
        put = address_of(go_to_free_place, on_agent)
        in_cell = (*on_agent, types.int64, types.int64, types.int64)
        gathered = {way: address_of(_GATHERERS[way], in_cell) for way in ways}
        # The last: where it is kept, a world is compiled.
        stepped = address_of(advance, types_stepped(params, motions))
    return Step(stepped, Parts(address_of(sense_agent, on_agent), put, **gathered))


def _form(value: Any) -> Any:
    """What the type of a value in compiled code depends on; to ask Numba for it takes 4 ms."""
    if isinstance(value, tuple):
        return tuple(map(_form, value))
    if isinstance(value, np.ndarray):
        return value.dtype, value.ndim, value.flags.c_contiguous, value.flags.writeable
    return type(value)


_GATHERERS = {"belt": gather_belt, "scatter": gather_scatter, "structure": gather_structure}
_steps: dict[Any, Step] = {}
_others: dict[Any, int] = {}
