"""Tuples by their address: the parts are those of the tuple, and its arrays are shared."""

import ctypes
from typing import Any, NamedTuple

import numba
import numpy as np
import numpy.typing as npt
from numba.core import types
from numba.extending import intrinsic

from reflexarc_sim_bridge.compiled import compiled
from reflexarc_sim_bridge.reference import Reference
from reflexarc_sim_bridge.world_step import stored


class Inner(NamedTuple):
    """A part that is a tuple itself."""

    numbers: npt.NDArray[np.float64]
    factor: float


class Outer(NamedTuple):
    """Parts of several kinds."""

    count: int
    inner: Inner
    is_on: bool


def _refer(_: Any, address: Any, like: Any) -> Any:
    """The tuple of the type of `like` that lies at an address."""

    def emit(context: Any, builder: Any, __: Any, args: Any) -> Any:
        return builder.inttoptr(args[0], context.get_value_type(Reference(like)))

    return Reference(like)(types.int64, like), emit


refer: Any = intrinsic(_refer)


@compiled
def put(outer: Outer, memory: npt.NDArray[np.int64]) -> int:
    """Put it down; returns its bytes."""
    size: int = stored(outer, memory)
    return size


@compiled
def double_all(address: int, like: Outer) -> float:
    """Read every part by reference, and write through the array."""
    outer = refer(address, like)
    inner, total = outer.inner, 0.0
    for k in range(outer.count):
        inner.numbers[k] *= inner.factor
        total += inner.numbers[k]
    return total if outer.is_on else 0.0


def test_parts_are_read_where_they_lie() -> None:
    numbers = np.array([1.0, 2.0, 3.0, 4.0])
    outer, memory = Outer(3, Inner(numbers, 2.0), True), np.zeros(64, np.int64)
    assert put(outer, memory) <= memory.nbytes
    assert double_all(memory.ctypes.data, outer) == 12.0
    np.testing.assert_array_equal(numbers, [2.0, 4.0, 6.0, 4.0])


def test_a_change_at_the_address_is_seen_at_the_next_call() -> None:
    outer, memory = Outer(1, Inner(np.ones(2), 1.0), True), np.zeros(64, np.int64)
    put(outer, memory)
    assert double_all(memory.ctypes.data, outer) == 1.0
    ctypes.c_int64.from_address(memory.ctypes.data).value = 2  # `count` comes first
    assert double_all(memory.ctypes.data, outer) == 2.0


def test_parts_have_their_types_and_tuples_are_references_again() -> None:
    typeof: Any = numba.typeof
    reference = Reference(typeof(Outer(1, Inner(np.ones(1), 1.0), True)))
    assert isinstance(reference.part("inner"), Reference)
    assert reference.part("count") is types.int64
