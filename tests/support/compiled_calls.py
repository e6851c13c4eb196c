"""Calls from Python of functions that only compiled ones can call."""

from collections.abc import Callable
from typing import Any, TypeVar

import numba

_Function = TypeVar("_Function", bound=Callable[..., Any])

_njit: Any = numba.njit  # its stub does not know `_nrt`


def from_python(function: _Function) -> _Function:
    """The same function for Python: compiled code that calls it."""

    @_njit(_nrt=False, error_model="numpy", no_cfunc_wrapper=True)
    def call(*arguments: Any) -> Any:
        return function(*arguments)

    return call  # type: ignore[no-any-return]  # it is called as the function is
