"""Compiling the world's step, part by part; what no world of a process needs is never compiled."""

from contextlib import ExitStack
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.arrays.layout import Params
from reflexarc_sim_bridge.arrays.workspace import IN_CELL, ON_AGENT, Parts
from reflexarc_sim_bridge.motion.placing import go_to_free_place
from reflexarc_sim_bridge.native.cache import compiling_alone, is_kept, is_shared
from reflexarc_sim_bridge.native.compile_progress import compilation
from reflexarc_sim_bridge.native.function_pointers import (
    FunctionPointer,
    Signature,
    function_table,
    pointer_to,
)
from reflexarc_sim_bridge.native.helper_process import compiled_meanwhile, has_room
from reflexarc_sim_bridge.native.numba_compiler import without_garbage_collection
from reflexarc_sim_bridge.obstacles.gathering import gatherers_for
from reflexarc_sim_bridge.simulation.lattice import LATTICE, look_along
from reflexarc_sim_bridge.simulation.step import advance, cast, cover, survey
from reflexarc_sim_bridge.simulation.step_pointer import CAST, COVER, STEP, SURVEY, type_of_held
from reflexarc_sim_bridge.vision.sensing import sense_agent
from reflexarc_sim_bridge.worlds.layers import layer_kinds
from reflexarc_sim_bridge.worlds.world import World, WorldSource

PUTTING, GATHERING = "where agents are put", "the drawing of obstacles"
STEPPING, LOOKING = "how agents move", "what agents see"

Motions = npt.NDArray[np.float64]
Gatherers = dict[tuple[int, int], Any]


class CompiledStep(NamedTuple):
    """A step, ready to be called."""

    advance: FunctionPointer
    """`step.advance`."""
    parts: Parts
    """What that calls."""


def step_for(source: WorldSource, params: Params, motions: Motions) -> CompiledStep:
    """The step of such a world, compiled unless that is done.

    Args:
        source: the world, or family of worlds.
        params: its simulation's.
        motions: linear, lateral and angular speed of each action: (actions, 3).
    """
    gatherers = gatherers_for(params.world, not isinstance(source, World))
    form = _form(params), _form(motions), tuple(gatherers.items())
    if form not in _steps:
        with compiling_alone("world"), without_garbage_collection():
            _steps[form] = _compile(params, motions, gatherers)
    return _steps[form]


def cover_for(params: Params, motions: Motions) -> FunctionPointer:
    """`step.cover`, compiled unless that is done."""
    return _pointer_to(cover, COVER, params, motions)


def cast_for(params: Params, motions: Motions) -> FunctionPointer:
    """`step.cast`, compiled unless that is done."""
    return _pointer_to(cast, CAST, params, motions)


def survey_for(params: Params, motions: Motions) -> FunctionPointer:
    """`step.survey`, compiled unless that is done."""
    return _pointer_to(survey, SURVEY, params, motions)


def lattice_for(params: Params, motions: Motions) -> FunctionPointer:
    """`lattice.look_along`, compiled unless that is done."""
    return _pointer_to(look_along, LATTICE, params, motions)


def _pointer_to(
    function: Any, signature: Signature, params: Params, motions: Motions
) -> FunctionPointer:
    form = signature, _form(params), _form(motions)
    if form not in _others:
        arguments = type_of_held(params, motions), *signature.arguments[1:]
        with compiling_alone(function.__name__), without_garbage_collection():
            _others[form] = pointer_to(function, signature, arguments)
    return _others[form]


def _compile(params: Params, motions: Motions, gatherers: Gatherers) -> CompiledStep:
    held = type_of_held(params, motions)
    pointed = held.field("params"), held.field("work")
    on_agent, in_cell = (*pointed, *ON_AGENT.arguments[2:]), (*pointed, *IN_CELL.arguments[2:])
    parts = _parts_to_compile(gatherers)
    with compilation(parts) as compiling, ExitStack() as helped:
        if LOOKING in parts and len(parts) > 1 and has_room() and is_shared():
            helped.enter_context(compiled_meanwhile(sense_agent, on_agent))
        with compiling.part(PUTTING):
            put = pointer_to(go_to_free_place, ON_AGENT, on_agent)
        with compiling.part(GATHERING):
            gathered = {k: pointer_to(one, IN_CELL, in_cell) for k, one in gatherers.items()}
            table = function_table(IN_CELL, gathered, (len(layer_kinds()), 2))
        with compiling.part(STEPPING):
            stepped = pointer_to(advance, STEP, (held, *STEP.arguments[1:]))
        with compiling.part(LOOKING):
            helped.close()  # waits for the second process
            look = pointer_to(sense_agent, ON_AGENT, on_agent)
    return CompiledStep(stepped, Parts(look, put, table))


def _parts_to_compile(gatherers: Gatherers) -> dict[str, float]:
    """The parts that are not on disk yet, and how many seconds each takes."""
    needed = {
        PUTTING: ([go_to_free_place], 5.0),
        GATHERING: (list(gatherers.values()), 4.0),
        STEPPING: ([advance], 4.5),
        LOOKING: ([sense_agent], 6.0),
    }
    return {
        part: expected_s
        for part, (functions, expected_s) in needed.items()
        if not all(map(is_kept, functions))
    }


def _form(value: Any) -> Any:
    """What the type of a value in compiled code depends on; to ask Numba for it takes 4 ms."""
    if isinstance(value, tuple):
        return tuple(map(_form, value))
    if isinstance(value, np.ndarray):
        return value.dtype, value.ndim, value.flags.c_contiguous, value.flags.writeable
    return type(value)


_steps: dict[Any, CompiledStep] = {}
_others: dict[Any, FunctionPointer] = {}
