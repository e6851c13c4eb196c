"""A simulation as one native structure, for compiled functions that Python calls at every step.

Called from Python, a compiled function is shown the type of every array that it is given and wraps
each of them, at every call: more than the step of an agent takes. So parameters, a workspace and
the motions of the actions are handed over once and held together (a `structref` of Numba: one
reference-counted structure); the call is given that alone.
"""

from typing import Any

import numba
import numpy as np
import numpy.typing as npt
from numba.experimental import structref

from reflexarc_sim_bridge.compiled import compiled_allocating
from reflexarc_sim_bridge.kernel import new_workspace
from reflexarc_sim_bridge.simulation import Simulation, motions_of


class HeldType(numba.types.StructRef):
    """Type of `Held` in compiled code."""


class Held(structref.StructRefProxy):
    """What a simulation's compiled functions need: `params`, `work`, `motions`.

    It shares the simulation's memory, and must be made anew for a copy of it.
    """


_structref: Any = structref  # its functions have no types
_structref.register(HeldType)
_structref.define_proxy(Held, HeldType, ["params", "work", "motions"])


def hold(simulation: Simulation) -> Held:
    """Hand a simulation over."""
    return _held(simulation.params, motions_of(simulation.contract))  # type: ignore[no-any-return]  # it makes one


@compiled_allocating
def _held(params: Any, motions: npt.NDArray[np.float64]) -> Any:
    return Held(params, new_workspace(params), motions)  # type: ignore[no-untyped-call]  # numba's
