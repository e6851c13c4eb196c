"""The only agent of a simulation as one native structure, for a function that Python calls often.

Called from Python, a compiled function is shown the type of every array that it is given and wraps
each of them, at every call: half a microsecond and more. So all that the step of one agent takes is
handed over once and held together (a `structref` of Numba: one reference-counted structure); the
call is given that alone.
"""

from typing import Any

import numba
import numpy as np
import numpy.typing as npt
from numba.experimental import structref

from reflexarc_sim_bridge.native.decorators import compiled_allocating


class OneHeldType(numba.types.StructRef):
    """Type of `OneHeld` in compiled code."""


_FIELDS = ["step", "world", "actions", "met", "states", "planes", "known"]


class OneHeld(structref.StructRefProxy):
    """Addresses of a step and of the world that it works on, and what the agent does and meets."""

    kept: Any = None
    """What lies at the second address."""


_structref: Any = structref  # its functions have no types
_structref.register(OneHeldType)
_structref.define_proxy(OneHeld, OneHeldType, _FIELDS)


@compiled_allocating
def hold(
    step: int, world: int, states: npt.NDArray[np.void], planes: npt.NDArray[np.void], known: int
) -> Any:
    """Hand an agent over.

    Args:
        step: address of `kernel.advance`.
        world: address of a `world_step.Held`, to be put into `kept`.
        states: `AGENT_DTYPE`: (1,).
        planes: `PLANE_DTYPE`: (1,).
        known: how many actions there are.
    """
    actions, met = np.zeros(1, np.int64), np.zeros(1, np.bool_)
    return OneHeld(step, world, actions, met, states, planes, known)  # type: ignore[no-untyped-call]  # numba's
