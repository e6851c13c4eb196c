"""Addresses of compiled functions for other compiled functions to call, each with its signature.

A function that is called by its name becomes part of its caller, and is optimised anew with each.
Called by its address it is compiled once for all, when the first one needs it, or never; and a
caller is the same code whichever function lies there. The price is that the processor is told
nothing of what it calls; so the address has a type, its signature, and a call with other arguments
fails when it is compiled.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from llvmlite import ir  # type: ignore[import-untyped]  # it has no stubs
from numba.core import types
from numba.core.datamodel import models
from numba.core.errors import TypingError
from numba.extending import NativeValue, intrinsic, register_model, typeof_impl, unbox

from reflexarc_sim_bridge.native.struct_pointers import AnyStruct, address_from_python

_WORD = ir.IntType(64)


class Signature(types.Type):
    """Type of the address of a function that returns nothing.

    Args:
        name: what the function does, in one word.
        arguments: what it takes: types of Numba, and classes of named tuples, which are handed over
            by their address, whatever arrays they hold.
    """

    def __init__(self, name: str, *arguments: Any) -> None:
        self.arguments = tuple(
            AnyStruct(each) if isinstance(each, type) else each for each in arguments
        )
        super().__init__(name=f"{name}({', '.join(map(str, self.arguments))})")

    def check(self, given: Sequence[Any], who: str) -> None:
        """Refuse arguments that such a function does not take.

        Raises:
            TypingError: Numba's, for it happens while a caller is compiled.
        """
        fits = len(given) == len(self.arguments) and all(
            wanted.takes(each) if isinstance(wanted, AnyStruct) else each == wanted
            for wanted, each in zip(self.arguments, given, strict=True)
        )
        if not fits:
            raise TypingError(f"{who}: expected {self}, got ({', '.join(map(str, given))})")


@dataclass(frozen=True)
class FunctionPointer:
    """Where a compiled function lies, and what it takes."""

    signature: Signature
    address: int = field(default=0)
    """0: nowhere, for a part that is never called."""

    def __bool__(self) -> bool:
        return self.address != 0


class FunctionTable(NamedTuple):
    """Addresses of functions with one signature, of which compiled code takes one by its place."""

    nowhere: FunctionPointer
    """Says what all of them take."""
    addresses: npt.NDArray[np.int64]
    """Where they lie; 0 where none is ever called: (rows, columns)."""


def function_table(
    signature: Signature,
    pointers: Mapping[tuple[int, int], FunctionPointer],
    shape: tuple[int, int],
) -> FunctionTable:
    """A table of functions by their places."""
    addresses = np.zeros(shape, np.int64)
    for place, pointer in pointers.items():
        addresses[place] = pointer.address
    return FunctionTable(FunctionPointer(signature), addresses)


def pointer_to(function: Any, signature: Signature, arguments: tuple[Any, ...]) -> FunctionPointer:
    """Compile a function that returns nothing, unless that is done; returns where it lies.

    Args:
        function: made by `compiled_called`.
        signature: what it must take.
        arguments: the types that it is compiled for, Numba's.

    Raises:
        TypingError: Numba's: the types do not fit the signature.
        TypeError: the function returns something.
    """
    signature.check(arguments, function.__name__)
    function.compile(arguments)
    result = function.overloads[arguments]
    if result.signature.return_type != types.none:
        raise TypeError(f"{function.__name__}: expected a function that returns nothing")
    return FunctionPointer(
        signature, int(result.library.get_pointer_to_function(result.fndesc.llvm_func_name))
    )


def _call(_: Any, pointer: Any, arguments: Any) -> Any:
    """Call the function at an address; the arguments are one tuple."""
    if not isinstance(pointer, Signature):
        raise TypingError(f"call by address: expected an address with a signature, got {pointer}")
    kinds = tuple(map(types.unliteral, arguments.types))
    pointer.check(kinds, "call by address")

    def emit(context: Any, builder: Any, __: Any, args: Any) -> Any:
        values = [builder.extract_value(args[1], k) for k in range(len(kinds))]
        form = context.call_conv.get_function_type(types.none, kinds)
        at = builder.inttoptr(args[0], form.as_pointer())
        context.call_conv.call_function(builder, at, types.none, kinds, values)
        return context.get_dummy_value()

    return types.void(pointer, arguments), emit


call: Any = intrinsic(_call)  # its stub says that a call returns nothing


def _at(_: Any, nowhere: Any, address: Any) -> Any:
    """An address, a number, as one with the signature of another."""

    def emit(_: Any, __: Any, ___: Any, args: Any) -> Any:
        return args[1]

    return nowhere(nowhere, types.int64), emit


at_address: Any = intrinsic(_at)  # the same


@register_model(Signature)
class _AddressModel(models.PrimitiveModel):
    """In memory and in registers an address is a word."""

    def __init__(self, manager: Any, kind: Signature) -> None:
        super().__init__(manager, kind, _WORD)  # type: ignore[no-untyped-call]  # numba's


@typeof_impl.register(FunctionPointer)
def _type_of_pointer(pointer: FunctionPointer, _: Any) -> Signature:
    return pointer.signature


def _unbox_pointer(_: Any, pointer: Any, c: Any) -> Any:
    word, failed = address_from_python(pointer, c)
    return _native_value(word, is_error=failed)


_native_value: Any = NativeValue
_unboxed: Any = unbox
_unboxed(Signature)(_unbox_pointer)
