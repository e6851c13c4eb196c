"""Decorators that compile Python functions to machine code, one for each way of calling them.

| decorator | called from | allocates | kept on disk |
|---|---|---|---|
| `compiled` | Python and compiled code | no | yes |
| `compiled_free` | Python, while its other threads run | no | yes |
| `compiled_allocating` | Python, while its other threads run | yes | yes |
| `compiled_called` | compiled code, by address (`function_pointers.py`) | no | yes |
| `compiled_inner` | compiled code | no | within its callers |
| `compiled_inline` | a hot loop of compiled code: becomes part of it | no | within its callers |
| `compiled_disjoint` | the same, over arrays that share no memory | no | within its callers |
| `compiled_part` | one or two places, where Numba puts it | no | within its callers |

Those that begin with `fused` are for the learners' arithmetic: a product and a sum may become one
instruction (`contract`), and a sum may be taken in another order (`reassoc`), without which a dot
product never becomes vector instructions. Neither touches NaN or infinity; and the order is fixed
when the function is compiled, so the same machine gives the same bits.

What holds for all of them:

- `error_model="numpy"`: a division by zero gives infinity and no exception; the check would keep
  loops over rays from becoming vector instructions. No divisor here can be zero.
- No `fastmath` but those two: it makes checks for NaN lie.
- Arrays are borrowed (`_nrt=False`): nothing counts references to them. Counting them for every
  array of every tuple that is handed on would take more time than the work itself, the more so as
  two threads would count on one place. Such a function can allocate nothing.
- Nothing is compiled, and no file is looked for, before the first call (`cache.py`).
"""

from collections.abc import Callable
from typing import Any, TypeVar

import numba

from reflexarc_sim_bridge.native.cache import keep_on_disk
from reflexarc_sim_bridge.native.numba_compiler import (
    DisjointCompiler,
    InnerCompiler,
    WideCompiler,
)
from reflexarc_sim_bridge.native.numba_version import check_numba_version

check_numba_version(numba.__version__)

_Function = TypeVar("_Function", bound=Callable[..., Any])

BORROWED = {"_nrt": False}
"""Numba's option for functions that count no references to arrays."""
_LIBERTIES = {"contract", "reassoc"}
_njit: Any = numba.njit  # its stub does not know all of its options


def compiled(function: _Function) -> _Function:
    """Compile a function at its first call, from Python or from compiled code.

    It allocates nothing.
    """
    return _kept(function)


def compiled_free(function: _Function) -> _Function:
    """The same; Python's other threads run during a call from Python."""
    return _kept(function, nogil=True)


def compiled_allocating(function: _Function) -> _Function:
    """The same for a function that makes arrays."""
    return _kept(function, _nrt=True, nogil=True)


def compiled_called(function: _Function) -> _Function:
    """Compile a large function that compiled code calls by its address; it returns nothing."""
    return _kept(function, pipeline_class=InnerCompiler)


def compiled_inner(function: _Function) -> _Function:
    """Compile a function that only compiled code calls.

    The wrapper that Python would need takes arguments out of Python's objects; for tuples of many
    arrays it is larger than the function.
    """
    return _inner(function)


def compiled_inline(function: _Function) -> _Function:
    """The same for a small function of a hot loop: LLVM puts it into its callers."""
    return _inner(function, forceinline=True)


def compiled_disjoint(function: _Function) -> _Function:
    """The same for a loop over arrays that share no memory: what it writes, it does not read back.

    The compiler need not test for that, nor load again what it has in its registers.
    """
    return _inner(function, forceinline=True, pipeline_class=DisjointCompiler)


def compiled_part(function: _Function) -> _Function:
    """A part of a large function, cut out to be read: Numba puts it in its place.

    For what has one or two callers. It is never compiled alone, which would take the same work
    again at every level of a call. Not for a caller that is `compiled_allocating`: it would count
    the references of all that it inlines.
    """
    return _inner(function, inline="always")


def fused_free(function: _Function) -> _Function:
    """As `compiled_free`, with the learners' arithmetic."""
    return _kept(function, nogil=True, fastmath=_LIBERTIES)


def fused(function: _Function) -> _Function:
    """As `compiled_inner`, with the learners' arithmetic."""
    return _inner(function, fastmath=_LIBERTIES)


def fused_inline(function: _Function) -> _Function:
    """As `compiled_inline`, with the learners' arithmetic.

    A call hands over tuples of arrays word by word, which takes longer than a loop over ten units.
    """
    return _inner(function, forceinline=True, fastmath=_LIBERTIES)


def fused_disjoint(function: _Function) -> _Function:
    """As `compiled_disjoint`, with the learners' arithmetic."""
    return _inner(function, forceinline=True, pipeline_class=DisjointCompiler, fastmath=_LIBERTIES)


def _inner(function: _Function, **options: Any) -> _Function:
    """Not kept by itself: its machine code is part of its callers', which are."""
    return _dispatcher(function, **{**BORROWED, "pipeline_class": InnerCompiler, **options})


def _kept(function: _Function, **options: Any) -> _Function:
    usual = {**BORROWED, "pipeline_class": WideCompiler}
    return keep_on_disk(_dispatcher(function, **{**usual, **options}))


def _dispatcher(function: _Function, **options: Any) -> _Function:
    compile_later = _njit(error_model="numpy", no_cfunc_wrapper=True, **options)
    return compile_later(function)  # type: ignore[no-any-return]  # it is called as the function is
