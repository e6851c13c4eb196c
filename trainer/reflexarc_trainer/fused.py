"""How the arithmetic of the learners compiles.

As `reflexarc_sim_bridge.compiled`, with its borrowed arrays, and two liberties more: a product and
a sum may become one instruction (`contract`), and a sum may be taken in another order (`reassoc`),
without which a dot product never becomes vector instructions. Neither touches NaN or infinity, so
checks for them keep their meaning; and the order is fixed when the function is compiled, so the
same machine gives the same bits.
"""

from collections.abc import Callable
from typing import Any, TypeVar

import numba

from reflexarc_sim_bridge.compile_cache import keyed_by_sources

_Function = TypeVar("_Function", bound=Callable[..., Any])

_njit: Any = numba.njit  # its stub does not know `_nrt`


def fused(function: _Function) -> _Function:
    """Compile a function at its first call; other compiled functions can call it.

    It allocates nothing.
    """
    with keyed_by_sources():
        dispatcher: Any = _njit(
            cache=True, error_model="numpy", fastmath={"contract", "reassoc"}, _nrt=False
        )(function)
    return dispatcher  # type: ignore[no-any-return]  # it is called as the function is
