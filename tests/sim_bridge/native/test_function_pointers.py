"""Functions called by their address, with the arguments that their signature says."""

from typing import NamedTuple

import numba
import numpy as np
import numpy.typing as npt
import pytest
from numba.core import types

from reflexarc_sim_bridge.native.decorators import compiled, compiled_called
from reflexarc_sim_bridge.native.function_pointers import (
    FunctionPointer,
    Signature,
    call,
    pointer_to,
)
from reflexarc_sim_bridge.native.struct_pointers import Struct, StructPointer

Numbers = npt.NDArray[np.int64]
ARRAY = types.int64[::1]


class Plan(NamedTuple):
    """What a part works on."""

    noted: Numbers
    factor: int


class Other(NamedTuple):
    """The same fields under another name."""

    noted: Numbers
    factor: int


THREE = Signature("three", Plan, types.int64, types.int64)
FOUR = Signature("four", Plan, ARRAY, types.int64, types.int64)


@compiled_called
def note_three(plan: Plan, first: int, second: int) -> None:
    """A part of one form."""
    plan.noted[0], plan.noted[1], plan.noted[2] = 3, first, second


@compiled_called
def note_four(plan: Plan, factors: Numbers, first: int, second: int) -> None:
    """A part of another."""
    noted = plan.noted
    noted[0], noted[1], noted[2] = 4, first * factors[0], second * plan.factor


@compiled_called
def note_nothing(plan: Plan, first: int, second: int) -> int:
    """No part: it returns something."""
    return first + second


@compiled
def call_three(three: FunctionPointer, plan: Struct) -> None:
    call(three, (plan, 10, 20))


@compiled
def call_four(four: FunctionPointer, plan: Struct, factors: Numbers) -> None:
    call(four, (plan, factors, 10, 20))


def pointed(noted: Numbers) -> tuple[FunctionPointer, FunctionPointer, Struct]:
    plan = Struct(Plan(noted, 2))
    kind = StructPointer(numba.typeof(plan.value))  # type: ignore[no-untyped-call]  # numba's
    return (
        pointer_to(note_three, THREE, (kind, types.int64, types.int64)),
        pointer_to(note_four, FOUR, (kind, ARRAY, types.int64, types.int64)),
        plan,
    )


def test_what_lies_at_an_address_gets_its_arguments() -> None:
    noted = np.zeros(3, np.int64)
    three, four, plan = pointed(noted)
    call_three(three, plan)
    assert noted.tolist() == [3, 10, 20]
    call_four(four, plan, np.array([7]))
    assert noted.tolist() == [4, 70, 40]


def test_a_part_lies_in_one_place() -> None:
    noted = np.zeros(3, np.int64)
    assert pointed(noted)[:2] == pointed(noted)[:2]


def test_a_call_with_other_arguments_than_the_signature_s_fails_when_it_is_compiled() -> None:
    three, four, plan = pointed(np.zeros(3, np.int64))
    with pytest.raises(numba.TypingError, match=r"expected four\(.*got \(Plan"):
        call_three(four, plan)
    with pytest.raises(numba.TypingError, match=r"expected three\(.*got \(Plan"):
        call_four(three, plan, np.array([7]))
    with pytest.raises(numba.TypingError, match=r"expected three\(Plan.*got \(Other"):
        call_three(three, Struct(Other(np.zeros(3, np.int64), 2)))
    with pytest.raises(numba.TypingError, match="expected an address with a signature, got int64"):
        call_three(three.address, plan)  # type: ignore[arg-type]  # the point


def test_a_function_that_does_not_fit_a_signature_has_no_pointer() -> None:
    kind = StructPointer(numba.typeof(Plan(np.zeros(3, np.int64), 2)))  # type: ignore[no-untyped-call]  # numba's
    with pytest.raises(numba.TypingError, match=r"note_three: expected four\("):
        pointer_to(note_three, FOUR, (kind, types.int64, types.int64))
    with pytest.raises(numba.TypingError, match=r"note_three: expected three\(.*float64"):
        pointer_to(note_three, THREE, (kind, types.int64, types.float64))
    with pytest.raises(TypeError, match="note_nothing: expected a function that returns nothing"):
        pointer_to(note_nothing, THREE, (kind, types.int64, types.int64))
