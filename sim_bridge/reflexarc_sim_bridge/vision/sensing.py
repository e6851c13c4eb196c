"""From the retinas of the eyes to the stack that the policy sees: disturbed, delayed, stacked.

Noise is added to every value and clipped, a lost ray reads 0; both are drawn anew at every
look from the agent's own stream. With latency the newest retina of the stack is an older one. A
slow sensor sends a new one only every few steps; until then the stack stays as it is. How many
steps its latency and its gap are, the world says (`worlds/stepping.py`).
"""

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.arrays.layout import Params, Row
from reflexarc_sim_bridge.arrays.workspace import Workspace
from reflexarc_sim_bridge.native.decorators import compiled_called, compiled_inner, compiled_part
from reflexarc_sim_bridge.native.splitmix64 import normal, uniform
from reflexarc_sim_bridge.obstacles.keys import draw
from reflexarc_sim_bridge.vision.ray_casting import look
from reflexarc_sim_bridge.vision.shading import keep_nearest, shade_rays, shade_tiles

_FULL = 255.0


@compiled_called
def sense_agent(params: Params, work: Workspace, i: int) -> None:
    """Look: agent `i`'s stack of retinas advances by what it sees now. Once a step."""
    eye, agents = params.eye, params.agents
    state = agents.state[i]
    plane = params.world.planes[state.world]
    is_due = state.looks == 0 or state.steps >= state.due
    if not is_due and plane.latency_steps == 0:
        state.looks += 1
        return
    is_disturbed = plane.noise > 0.0 or plane.dropout > 0.0
    is_plain = eye.frames == 1 and plane.latency_steps == 0 and not is_disturbed
    values = agents.stack[i] if is_plain else work.retina
    for eye_index in range(eye.eyes):
        look(params, work, i, eye_index)
        if eye.samples > eye.blended:
            keep_nearest(eye.rays, eye.samples, work.distance_m, work.paint)
        if eye.is_plain:
            shade_tiles(eye, work, plane.background, values)
        else:
            start = eye_index * eye.rays * eye.channels
            shade_rays(eye, work, plane.background, values, start)
    if is_due and plane.gap_steps > 1:
        state.due = state.steps + 1 + int(plane.gap_steps * uniform(draw(plane, state)))
    if is_plain:
        state.looks += 1
        return
    if is_disturbed:
        _disturb(plane, state, eye.alive, eye.channels, work.retina)
    _remember(params, work, i, is_due)


@compiled_inner
def _disturb(
    plane: Row,
    state: Row,
    alive: npt.NDArray[np.bool_],
    channels: int,
    retina: npt.NDArray[np.uint8],
) -> None:
    """Add noise to every value and silence lost rays, both drawn anew at every look."""
    for ray in range(retina.size // channels):
        lost = plane.dropout > 0.0 and uniform(draw(plane, state)) < plane.dropout
        silent = lost or not alive[ray % alive.size]
        for at in range(ray * channels, (ray + 1) * channels):
            noise = plane.noise * normal(draw(plane, state)) if plane.noise > 0.0 else 0.0
            bright = min(max(retina[at] / _FULL + noise, 0.0), 1.0)
            retina[at] = 0 if silent else int(_FULL * bright + 0.5)


@compiled_part
def _remember(params: Params, work: Workspace, i: int, is_due: bool) -> None:
    """Push the retina of `latency_steps` looks ago onto the stack, if a new one is due.

    The first look fills it.
    """
    agents, state = params.agents, params.agents.state[i]
    delayed, stack, size = agents.delayed[i], agents.stack[i], agents.delayed.shape[2]
    depth, frames = delayed.shape[0], params.eye.frames
    now = state.looks % depth if depth > 1 else 0
    for slot in range(depth):
        if slot == now or state.looks == 0:
            for at in range(size):
                delayed[slot, at] = work.retina[at]
    if not is_due:
        state.looks += 1
        return
    oldest = (now + 1) % depth if depth > 1 else 0
    if state.looks > 0:
        for at in range(stack.size - size):
            stack[at] = stack[at + size]
    for frame in range(frames - 1 if state.looks > 0 else 0, frames):
        for at in range(size):
            stack[frame * size + at] = delayed[oldest, at]
    state.looks += 1
