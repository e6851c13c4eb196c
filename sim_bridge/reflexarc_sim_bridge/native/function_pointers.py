"""Compiled functions that other compiled ones call by their address.

One that is called by its name becomes part of its caller, and is optimised anew with each. Called
by its address it is compiled once for all, when the first one needs it, or never; and a caller is
the same code whichever function lies there.
"""

from typing import Any

from numba.core import types
from numba.extending import intrinsic


def address_of(function: Any, arguments: tuple[Any, ...]) -> int:
    """Compile a function that returns nothing, unless that is done; returns where it lies.

    Args:
        function: made by `compiled_called`.
        arguments: their types, Numba's.

    Raises:
        TypeError: it has no machine code. Numba's: it returns something.
    """
    function.compile(arguments)
    result = function.get_compile_result(types.void(*arguments))
    address = int(result.library.get_pointer_to_function(result.fndesc.llvm_func_name))
    if address == 0:
        raise TypeError(f"{function.__name__}: expected a function that is `compiled_called`")
    return address


def _call(_: Any, address: Any, arguments: Any) -> Any:
    """Call what lies at an address; the arguments are one tuple."""
    kinds = tuple(map(types.unliteral, arguments.types))

    def emit(context: Any, builder: Any, __: Any, args: Any) -> Any:
        values = [builder.extract_value(args[1], k) for k in range(len(kinds))]
        emit_call(context, builder, args[0], kinds, values)
        return context.get_dummy_value()

    return types.void(address, arguments), emit


def emit_call(context: Any, builder: Any, address: Any, kinds: Any, values: Any) -> None:
    """Write the call of what lies at an address, for arguments of such kinds."""
    form = context.call_conv.get_function_type(types.none, kinds)
    at = builder.inttoptr(address, form.as_pointer())
    context.call_conv.call_function(builder, at, types.none, kinds, values)


def _pointer(_: Any, address: Any) -> Any:
    """An address as an argument that is asked for by reference."""

    def emit(context: Any, builder: Any, __: Any, args: Any) -> Any:
        return builder.inttoptr(args[0], context.get_value_type(types.voidptr))

    return types.voidptr(address), emit


# The stub of `intrinsic` says that a call returns nothing.
call: Any = intrinsic(_call)
pointer: Any = intrinsic(_pointer)
