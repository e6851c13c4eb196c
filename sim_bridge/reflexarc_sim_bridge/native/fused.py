"""How the arithmetic of the learners compiles.

As `reflexarc_sim_bridge.native.decorators`, with its borrowed arrays, and two liberties more: a product and
a sum may become one instruction (`contract`), and a sum may be taken in another order (`reassoc`),
without which a dot product never becomes vector instructions. Neither touches NaN or infinity, so
checks for them keep their meaning; and the order is fixed when the function is compiled, so the
same machine gives the same bits.
"""

from collections.abc import Callable
from typing import Any, TypeVar

import numba

from reflexarc_sim_bridge.native.cache import keyed_by_sources
from reflexarc_sim_bridge.native.lean import LeanCompiler
from reflexarc_sim_bridge.native.linked import linked

_Function = TypeVar("_Function", bound=Callable[..., Any])

_LIBERTIES = {"contract", "reassoc"}
_njit: Any = numba.njit  # its stub does not know `_nrt`


def fused_free(function: _Function) -> _Function:
    """Compile a function that Python calls, at its first call; other threads can run meanwhile.

    It allocates nothing.
    """
    return _fused(function, nogil=True)


def fused(function: _Function) -> _Function:
    """The same for one that only compiled functions call: Python cannot, which saves a wrapper."""
    return _linked(function)


def fused_inline(function: _Function) -> _Function:
    """The same for a part of a hot loop: it becomes part of whoever calls it.

    A call hands over tuples of arrays word by word, which takes longer than a loop over ten units.
    """
    return _linked(function, forceinline=True)


def fused_disjoint(function: _Function) -> _Function:
    """The same for a loop over arrays that share no memory; it becomes part of whoever calls it."""
    return _linked(function, forceinline=True, noalias=True)


def _linked(function: _Function, **options: Any) -> _Function:
    with keyed_by_sources():
        return linked(function, fastmath=_LIBERTIES, **options)  # type: ignore[no-any-return]


def _fused(function: _Function, **options: Any) -> _Function:
    with keyed_by_sources():
        dispatcher: Any = _njit(
            cache=True,
            error_model="numpy",
            fastmath=_LIBERTIES,
            _nrt=False,
            no_cfunc_wrapper=True,
            pipeline_class=LeanCompiler,
            **options,
        )(function)
    return dispatcher  # type: ignore[no-any-return]  # it is called as the function is
