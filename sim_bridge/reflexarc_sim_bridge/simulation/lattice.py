"""Which steps on a lattice of places meet an obstacle, by the contacts of the simulation itself.

A body that goes ahead equally far at every step, and sideways by a multiple of one length, is
always at a place of a lattice: after n steps at x = n · ahead, in one of some rows. This module
says of every row and step whether a body could stand there, and which of its motions would end in a
contact. A step begins at the time of its number, so obstacles that move are where they are then.

Nothing here has a geometry of its own: a verdict is that of `contact.free_share` and
`overlap.touches`, which move the agents. To be quick, whole runs of steps are passed over where
nothing is near, by the first, coarse test of the contacts (`broad_phase`); the run is
doubled where that succeeds, and halved where it fails.
"""

from typing import Any

import numpy as np
import numpy.typing as npt
from numba.core import types

from reflexarc_sim_bridge.arrays.layout import (
    AT_REST,
    BOXES,
    DISCS,
    OPEN,
    SIDES,
    TURNED,
    Params,
)
from reflexarc_sim_bridge.arrays.workspace import Workspace
from reflexarc_sim_bridge.motion.broad_phase import (
    WayBounds,
    boxes_touched,
    discs_touched,
    sides_touched,
    turned_touched,
)
from reflexarc_sim_bridge.motion.contact import free_share
from reflexarc_sim_bridge.motion.overlap import TOUCHING_M, touches
from reflexarc_sim_bridge.motion.placing import set_place
from reflexarc_sim_bridge.native.decorators import (
    compiled_called,
    compiled_free,
    compiled_inline,
    compiled_inner,
)
from reflexarc_sim_bridge.native.function_pointers import FunctionPointer, Signature, call
from reflexarc_sim_bridge.native.struct_pointers import Struct
from reflexarc_sim_bridge.obstacles.gathering import keep_near
from reflexarc_sim_bridge.obstacles.keys import layer_key
from reflexarc_sim_bridge.obstacles.kinds.corridor import corridor_line_m
from reflexarc_sim_bridge.obstacles.near_lists import forget_near, near_of, place_in_layer_m
from reflexarc_sim_bridge.simulation.step_pointer import Held
from reflexarc_sim_bridge.worlds.grid import CHUNK_M

COVERED = 128
"""Bit of a place where nobody can stand: in an obstacle, or beyond a corridor's wall. The bits
below say which motions meet something."""
MOST_MOTIONS = 7

LATTICE = Signature(
    "lattice",
    Held,
    types.float64,
    types.float64[::1],
    types.float64,
    types.float64[::1],
    types.int64,
    types.uint8[:, ::1],
)
"""What `look_along` takes."""

_MORE_M = 1e-4
"""By so much the coarse test is wider than the fine one: float32 is exact to a micrometre here."""


@compiled_called
def look_along(
    held: Any,
    start_m: float,
    rows_m: npt.NDArray[np.float64],
    ahead_m: float,
    left_m: npt.NDArray[np.float64],
    first: int,
    found_out: npt.NDArray[np.uint8],
) -> None:
    """What a body would meet, row by row; agent 0 is put there.

    Args:
        held: parameters and scratch of a simulation: a `Held`.
        start_m: place ahead, of step `first`.
        rows_m: lateral places, to the left: (rows,).
        ahead_m: how far each step goes ahead.
        left_m: how far each motion goes to the left: (motions,), at most MOST_MOTIONS.
        first: number of the first step.
        found_out: filled: bit k of a place where motion k meets something, or COVERED:
            (steps, rows).
    """
    params, work, steps = held.params, held.work, len(found_out)
    most_left_m = 0.0
    for k in range(len(left_m)):
        most_left_m = max(most_left_m, abs(left_m[k]))
    for row in range(len(rows_m)):
        forget_near(params.agents, 0)
        n, run = 0, 1
        while n < steps:
            x_m = start_m + n * ahead_m
            _stand(params, work, first + n, x_m, rows_m[row])
            run = min(run, _steps_in_cell(params, ahead_m), steps - n)
            if _is_clear(params, work, run * ahead_m, most_left_m):
                for k in range(run):
                    found_out[n + k, row] = 0
                n, run = n + run, 2 * run
            elif run > 1:
                run = run // 2
            else:
                found_out[n, row] = _found(params, work, ahead_m, left_m)
                n += 1


@compiled_inner
def _stand(params: Params, work: Workspace, step: int, x_m: float, y_m: float) -> None:
    """Put agent 0 at a place, at the time of a step."""
    state = params.agents.state[0]
    state.steps = step
    set_place(params.world.planes[state.world], state, 0, x_m, 0, y_m)
    keep_near(params, work, 0)


@compiled_inline
def _steps_in_cell(params: Params, ahead_m: float) -> int:
    """In how many steps from here on a body begins before it enters another cell; at least one.

    One where anything moves: the lists of a layer that moves are of the time.
    """
    state = params.agents.state[0]
    plane = params.world.planes[state.world]
    for number in range(plane.layers):
        if params.world.layers[state.world, number].motion != AT_REST:
            return 1
    return max(1, int((CHUNK_M - state.x_m) / ahead_m))


@compiled_inner
def _is_clear(params: Params, work: Workspace, ahead_m: float, left_m: float) -> bool:
    """Whether nothing at rest is near a strip ahead of agent 0; False if in doubt."""
    world, agents = params.world, params.agents
    state = agents.state[0]
    plane, judged = world.planes[state.world], work.sieve.judged
    reach_x = np.float32(0.5 * ahead_m + plane.radius_m + TOUCHING_M + _MORE_M)
    reach_y = np.float32(left_m + plane.radius_m + TOUCHING_M + _MORE_M)
    has_sides = False
    for number in range(plane.layers):
        layer = world.layers[state.world, number]
        if layer.motion != AT_REST:
            return False
        x_m, y_m = place_in_layer_m(plane, layer, state, agents.layer_cells[0, number])
        box = WayBounds(np.float32(x_m + 0.5 * ahead_m), np.float32(y_m), reach_x, reach_y)
        near = near_of(agents, 0, number)
        if near.counts[BOXES] and boxes_touched(near.boxes, near.counts[BOXES], box, judged):
            return False
        if near.counts[TURNED] and turned_touched(near.turned, near.counts[TURNED], box, judged):
            return False
        if near.counts[DISCS] and discs_touched(near.discs, near.counts[DISCS], box, judged):
            return False
        if near.counts[SIDES] and sides_touched(near.sides, near.counts[SIDES], box, judged):
            return False
        has_sides |= near.counts[SIDES] > 0
    # Within a large polygon no side is near.
    return not (has_sides and not _can_stand(params))


@compiled_inner
def _found(params: Params, work: Workspace, ahead_m: float, left_m: npt.NDArray[np.float64]) -> int:
    """The bits of the place where agent 0 is."""
    if not _can_stand(params):
        return COVERED
    state = params.agents.state[0]
    plane, found = params.world.planes[state.world], 0
    for k in range(len(left_m)):
        way_m = left_m[k]
        if plane.edges == OPEN:
            y_m = state.cell_y * plane.chunk_width_m + state.y_m
            way_m = min(max(y_m + way_m, 0.0), plane.width_m) - y_m
        found |= (free_share(params, work, 0, ahead_m, way_m) <= 1.0) << k
    return found


@compiled_inner
def _can_stand(params: Params) -> bool:
    """Whether agent 0 is clear of obstacles, and between the walls where there are any."""
    state = params.agents.state[0]
    plane = params.world.planes[state.world]
    if plane.corridor >= 0:
        layer = params.world.layers[state.world, plane.corridor]
        key = layer_key(plane.stream, state.seed, plane.corridor)
        middle_m = corridor_line_m(layer, key, state.cell_x * CHUNK_M + state.x_m)
        y_m = state.cell_y * plane.chunk_width_m + state.y_m
        if abs(y_m - middle_m) > layer.half_width_m:
            return False
    return not touches(params, 0)


@compiled_free
def call_lattice(
    lattice: FunctionPointer,
    held: Struct,
    start_m: float,
    rows_m: npt.NDArray[np.float64],
    ahead_m: float,
    left_m: npt.NDArray[np.float64],
    first: int,
    found_out: npt.NDArray[np.uint8],
) -> None:
    """Call `look_along` from Python; `held` is a `Held`."""
    call(lattice, (held, start_m, rows_m, ahead_m, left_m, first, found_out))
