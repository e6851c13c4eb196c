"""Tuples by their address: the parts are those of the tuple, and its arrays are shared."""

from typing import Any, NamedTuple

import numba
import numpy as np
import numpy.typing as npt
import pytest
from numba.core import types
from numba.extending import intrinsic

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_sim_bridge.native.decorators import compiled
from reflexarc_sim_bridge.native.struct_pointers import StructPointer, laid_out
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.world import World


class Inner(NamedTuple):
    """A part that is a tuple itself, which takes up less than whole words."""

    numbers: npt.NDArray[np.float64]
    factor: float
    is_small: bool


class Outer(NamedTuple):
    """Parts of several kinds."""

    count: int
    is_on: bool
    share: np.float32
    inner: Inner
    table: npt.NDArray[np.float32]
    is_last: bool


def _refer(_: Any, address: Any, like: Any) -> Any:
    """The tuple of the type of `like` that lies at an address."""

    def emit(context: Any, builder: Any, __: Any, args: Any) -> Any:
        return builder.inttoptr(args[0], context.get_value_type(StructPointer(like)))

    return StructPointer(like)(types.int64, like), emit


refer: Any = intrinsic(_refer)


def _size(_: Any, like: Any) -> Any:
    """Bytes that Numba takes for a value in memory."""

    def emit(context: Any, builder: Any, signature: Any, __: Any) -> Any:
        form = context.get_data_type(signature.args[0])
        return context.get_constant(types.intp, context.get_abi_sizeof(form))

    return types.intp(like), emit


size: Any = intrinsic(_size)


@compiled
def size_of(value: Any) -> int:
    """The same, to be called from Python."""
    return int(size(value))


@compiled
def double_all(address: int, like: Outer) -> float:
    """Read every part by reference, and write through the array."""
    outer = refer(address, like)
    inner, total = outer.inner, 0.0
    for k in range(outer.count):
        inner.numbers[k] *= inner.factor
        total += inner.numbers[k]
    if outer.is_on and not inner.is_small and outer.is_last:
        return total * outer.share * outer.table[1, 2]
    return 0.0


def outer_of(numbers: npt.NDArray[np.float64], factor: float = 2.0) -> Outer:
    table = np.zeros((3, 8), np.float32)[:, ::2]
    table[1, 2] = 10.0
    inner = Inner(numbers, factor, False)
    return Outer(len(numbers), True, np.float32(0.5), inner, table, True)


def test_fields_are_read_where_they_lie() -> None:
    numbers = np.array([1.0, 2.0, 3.0])
    outer = outer_of(numbers)
    memory = laid_out(outer)
    assert double_all(memory.ctypes.data, outer) == 60.0
    np.testing.assert_array_equal(numbers, [2.0, 4.0, 6.0])


def test_what_is_laid_out_is_as_long_as_what_numba_lays_out() -> None:
    outer = outer_of(np.ones(1))
    assert laid_out(outer).itemsize == size_of(outer)
    seeds = np.arange(2, dtype=np.uint64)
    params = Simulation(World("plain"), PolicyContract(), seeds).params
    assert laid_out(params).itemsize == size_of(params)


def test_a_change_at_the_address_is_seen_at_the_next_call() -> None:
    outer = outer_of(np.ones(2), factor=1.0)
    memory = laid_out(outer)
    assert double_all(memory.ctypes.data, outer) == 10.0
    memory["count"] = 1
    assert double_all(memory.ctypes.data, outer) == 5.0


@pytest.mark.parametrize("part", [None, "text", (1, 2), [1.0]])
def test_what_compiled_code_would_read_wrongly_is_refused(part: object) -> None:
    with pytest.raises(TypeError, match="laid_out: expected"):
        laid_out(outer_of(np.ones(1))._replace(count=part))  # type: ignore[arg-type]  # the point


def test_fields_have_their_types_and_tuples_are_addresses_again() -> None:
    typeof: Any = numba.typeof
    reference = StructPointer(typeof(outer_of(np.ones(1))))
    assert isinstance(reference.field("inner"), StructPointer)
    assert reference.field("count") is types.int64
