"""How this package compiles: one decorator for one agent's work, one for the work of all.

- Cached on disk: half a minute of compilation once, half a second from then on.
- `error_model="numpy"`: a division by zero gives infinity and not an exception; the check would
  keep loops over rays from becoming vector instructions. No divisor here can be zero.
- No `fastmath`: it makes checks for NaN lie, and it is slower here.
- Arrays are borrowed: `compiled` functions count no references (`_nrt=False`). Counting them for
  every array of every tuple that is handed on would take more time than the work itself, the
  more so as two threads would count on one place. Such a function can therefore allocate nothing;
  those that do are `compiled_allocating`, and few.
"""

from collections.abc import Callable
from typing import Any, TypeVar

import numba
from numba.core.cpu import CPUTargetOptions
from numba.core.options import TargetOptions

from reflexarc_sim_bridge.native.cache import keyed_by_sources
from reflexarc_sim_bridge.native.lean import LeanCompiler
from reflexarc_sim_bridge.native.linked import linked

_Function = TypeVar("_Function", bound=Callable[..., Any])

# numba knows this flag, which its own parallel loops use, but has no option for it.
_mapping: Any = TargetOptions.Mapping
CPUTargetOptions.noalias = _mapping("noalias")


def compiled(function: _Function) -> _Function:
    """Compile a function at its first call; other compiled functions can call it.

    It allocates nothing.
    """
    return _compiled(function, _nrt=False)


def compiled_inner(function: _Function) -> _Function:
    """The same for a function that only compiled ones call: Python cannot, which saves a wrapper.

    The wrapper takes arguments out of Python's objects; for tuples of many arrays it is larger than
    the function.
    """
    return _linked(function)


def compiled_inline(function: _Function) -> _Function:
    """The same for a small function of a hot loop: it becomes part of whoever calls it."""
    return _linked(function, forceinline=True)


def compiled_disjoint(function: _Function) -> _Function:
    """The same for a loop over arrays that share no memory: what it writes, it does not read back.

    The compiler need not test for that, nor load again what it has in its registers.
    """
    return _linked(function, forceinline=True, noalias=True)


def compiled_part(function: _Function) -> _Function:
    """A part of a large function, cut out to be read: put in its place before it is compiled.

    For what has one or two callers. It is never compiled alone, which would take the same work
    again at every level of a call. Not for a caller that is `compiled_allocating`: it would count
    the references of all that it inlines.
    """
    return _linked(function, inline="always")


def compiled_allocating(function: _Function) -> _Function:
    """For a function that makes arrays, too; other threads of Python can run meanwhile."""
    return _compiled(function, _nrt=True, nogil=True)


def compiled_free(function: _Function) -> _Function:
    """As `compiled`, called from Python: other threads can run meanwhile."""
    return _compiled(function, _nrt=False, nogil=True)


def compiled_called(function: _Function) -> _Function:
    """For a large function that other compiled ones call by its address (`by_address.py`).

    It allocates nothing and returns nothing.
    """
    return _compiled(function, _nrt=False, no_cpython_wrapper=True)


def _linked(function: _Function, **options: Any) -> _Function:
    with keyed_by_sources():
        return linked(function, **options)  # type: ignore[no-any-return]  # as `_compiled`


def _compiled(function: _Function, **options: Any) -> _Function:
    njit: Any = numba.njit  # its stub does not know all of its options
    with keyed_by_sources():
        compile_later = njit(
            cache=True,
            error_model="numpy",
            no_cfunc_wrapper=True,
            pipeline_class=LeanCompiler,
            **options,
        )
        return compile_later(function)  # type: ignore[no-any-return]  # called as the function is


_LIBERTIES = {"contract", "reassoc"}
_njit: Any = numba.njit  # its stub does not know `_nrt`


def fused_free(function: _Function) -> _Function:
    """Compile a function that Python calls, at its first call; other threads can run meanwhile.

    It allocates nothing.
    """
    return _fused(function, nogil=True)


def fused(function: _Function) -> _Function:
    """The same for one that only compiled functions call: Python cannot, which saves a wrapper."""
    return _fused_linked(function)


def fused_inline(function: _Function) -> _Function:
    """The same for a part of a hot loop: it becomes part of whoever calls it.

    A call hands over tuples of arrays word by word, which takes longer than a loop over ten units.
    """
    return _fused_linked(function, forceinline=True)


def fused_disjoint(function: _Function) -> _Function:
    """The same for a loop over arrays that share no memory; it becomes part of whoever calls it."""
    return _fused_linked(function, forceinline=True, noalias=True)


def _fused_linked(function: _Function, **options: Any) -> _Function:
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
