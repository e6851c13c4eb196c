"""Single instructions of the processor that Python has no word for.

- `keep`: which entries of a list pass a test is known for a whole vector at once; to write only
  those behind each other is one instruction where the processor has it (AVX-512: `vpcompressd`),
  and a loop that writes first and counts after would take one step an entry.
- `fetch`: ask for memory that will be needed soon.
- `multiply_add`: a·b + c rounded once. Asked for by name: left to the compiler's choice, bits would
  depend on what it makes of a loop.
"""

from typing import Any

from llvmlite import ir  # type: ignore[import-untyped]  # it has no stubs
from numba.core import types
from numba.extending import intrinsic

from reflexarc_sim_bridge.native.decorators import compiled

LANES = 16
"""Entries that are treated together; arrays have room for so many more than they hold."""

_SUFFIXES = {types.float32: "f32", types.int32: "i32", types.uint32: "i32"}
_READ, _KEEP_IN_ALL_CACHES, _DATA = 0, 3, 1


@compiled
def whole(count: int) -> int:
    """Round a count up to a multiple of `LANES`: a loop over so many is whole vectors."""
    return (count + LANES - 1) // LANES * LANES


def _keep(_: Any, values: Any, marks: Any, first: Any, kept: Any, count: Any) -> Any:
    """Write those of `values[first : first + LANES]` that are marked from `kept[count]` on.

    Args:
        values: 32-bit numbers: (n + LANES,).
        marks: bytes 0 or 1: (n + LANES,).
        first: where they begin.
        kept: as `values`; up to `LANES` entries are written, whatever is marked.
        count: where those kept so far end.

    Returns:
        Where those kept end now.
    """

    def emit(context: Any, builder: Any, __: Any, args: Any) -> Any:
        def at(kind: Any, array: Any, index: Any) -> Any:
            data = context.make_array(kind)(context, builder, array).data
            lanes = ir.VectorType(context.get_data_type(kind.dtype), LANES)
            return builder.bitcast(builder.gep(data, [index]), lanes.as_pointer())

        bits, one = ir.VectorType(ir.IntType(1), LANES), ir.IntType(16)
        marked = builder.load(at(marks, args[1], args[2]), align=1)
        mask = builder.icmp_unsigned("!=", marked, ir.Constant(marked.type, None))
        lanes = builder.load(at(values, args[0], args[2]), align=4)
        name = "llvm.experimental.vector.compress.v16" + _SUFFIXES[values.dtype]
        form = ir.FunctionType(lanes.type, [lanes.type, bits, lanes.type])
        compress = _declared(builder.module, form, name)
        packed = builder.call(compress, [lanes, mask, ir.Constant(lanes.type, ir.Undefined)])
        builder.store(packed, at(kept, args[3], args[4]), align=4)
        found = builder.ctpop(builder.bitcast(mask, one))
        return builder.add(args[4], builder.zext(found, args[4].type))

    return types.int64(values, marks, types.int64, kept, types.int64), emit


def _fetch(_: Any, array: Any, index: Any) -> Any:
    """Let the processor read `array[index]` into its cache, without waiting for it."""

    def emit(context: Any, builder: Any, __: Any, args: Any) -> Any:
        data = context.make_array(array)(context, builder, args[0]).data
        at, number = builder.gep(data, [args[1]]), ir.IntType(32)
        form = ir.FunctionType(ir.VoidType(), [at.type, number, number, number])
        how = map(number, (_READ, _KEEP_IN_ALL_CACHES, _DATA))
        builder.call(_declared(builder.module, form, "llvm.prefetch.p0"), [at, *how])
        return context.get_dummy_value()

    return types.void(array, types.int64), emit


def _multiply_add(_: Any, a: Any, b: Any, c: Any) -> Any:
    """a·b + c, of three numbers of one floating-point type."""

    def emit(context: Any, builder: Any, __: Any, args: Any) -> Any:
        kind = context.get_data_type(a)
        name = f"llvm.fma.f{a.bitwidth}"
        form = ir.FunctionType(kind, [kind, kind, kind])
        return builder.call(_declared(builder.module, form, name), args)

    return a(a, a, a), emit


def _declared(module: Any, form: Any, name: str) -> Any:
    """A function of LLVM's own, made known to a module once."""
    return module.globals.get(name) or ir.Function(module, form, name)


# The stub of `intrinsic` says that a call returns nothing.
keep: Any = intrinsic(_keep)
fetch: Any = intrinsic(_fetch)
multiply_add: Any = intrinsic(_multiply_add)
