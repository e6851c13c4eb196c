"""How this package compiles: one decorator for one agent's work, one for the work of all.

- Cached on disk: 20 s of compilation once, half a second from then on.
- `error_model="numpy"`: a division by zero gives infinity and not an exception; the check would
  keep loops over rays from becoming vector instructions. No divisor here can be zero.
- No `fastmath`: it makes checks for NaN lie, and it is slower here.
- Arguments of hot functions are numbers and the few arrays that they use: handing over a whole
  named tuple of arrays counts references to each of them.
"""

from collections.abc import Callable
from typing import Any, TypeVar

import numba

from reflexarc_sim_bridge.compile_cache import keyed_by_sources

_Function = TypeVar("_Function", bound=Callable[..., Any])

prange = numba.prange


def compiled(function: _Function) -> _Function:
    """Compile a function at its first call; other compiled functions can call it."""
    with keyed_by_sources():
        dispatcher: Any = numba.njit(cache=True, error_model="numpy")(function)
    return dispatcher  # type: ignore[no-any-return]  # it is called as the function is


def compiled_parallel(function: _Function) -> _Function:
    """The same, with its `prange` loops shared among threads.

    A loop's body is one call that is given the whole tuple of arrays. Where the body also names an
    array of that tuple, the two are compiled as if they shared no memory, and what the call wrote
    is not seen.
    """
    with keyed_by_sources():
        dispatcher: Any = numba.njit(cache=True, error_model="numpy", parallel=True)(function)
    return dispatcher  # type: ignore[no-any-return]  # it is called as the function is
