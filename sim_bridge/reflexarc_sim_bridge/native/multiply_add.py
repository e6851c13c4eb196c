"""a·b + c rounded once: one instruction, where the processor has it, in place of two.

Asked for by name: left to the compiler's choice, bits would depend on what it makes of a loop.
"""

from typing import Any

from llvmlite import ir  # type: ignore[import-untyped]  # it has no stubs
from numba.extending import intrinsic

from reflexarc_sim_bridge.native.intrinsics import declared


def _multiply_add(_: Any, a: Any, b: Any, c: Any) -> Any:
    """a·b + c, of three numbers of one floating-point type."""

    def emit(context: Any, builder: Any, __: Any, args: Any) -> Any:
        kind = context.get_data_type(a)
        name = f"llvm.fma.f{a.bitwidth}"
        form = ir.FunctionType(kind, [kind, kind, kind])
        return builder.call(declared(builder.module, form, name), args)

    return a(a, a, a), emit


multiply_add: Any = intrinsic(_multiply_add)  # its stub says that a call returns nothing
