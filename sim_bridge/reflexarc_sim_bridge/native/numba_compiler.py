"""Numba's compiler with one pass changed: the lowering, which writes LLVM's intermediate code.

Numba's own pass builder makes the row of passes; in it `NativeLowering` gives its place to ours,
which adds what Numba has no option for:

- Vectors of 512 bits. LLVM takes half of them unless a function asks for more, from the days when
  whole ones made the clock slower for everything else. A tile of sixteen rays is one such vector.
- `noalias`, for loops over arrays that share no memory: what such a loop writes it need not read
  back. Numba has the flag for its own parallel loops.
- A function that only compiled code calls gets no wrapper for Python, which would be larger than
  the function; a call from Python raises TypeError.

Measured gains, and what happens should a version of Numba differ: see README.md in this folder.
"""

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, ClassVar

from llvmlite import ir  # type: ignore[import-untyped]  # it has no stubs
from numba.core import types
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import PassManager, register_pass
from numba.core.lowering import Lower
from numba.core.typed_passes import NativeLowering

from reflexarc_sim_bridge.native.cache import prepare

_registered: Any = register_pass(mutates_CFG=True, analysis_only=False)  # type: ignore[no-untyped-call]

FUNCTION_ATTRIBUTES = {'"prefer-vector-width"="512"'}
"""What every function asks of LLVM."""


class _WideLower(Lower):
    def setup_function(self, fndesc: object) -> None:
        super().setup_function(fndesc)  # type: ignore[no-untyped-call]
        # llvmlite's own `update` knows no attributes with values.
        set.update(self.function.attributes, FUNCTION_ATTRIBUTES)


class _InnerLower(_WideLower):
    def create_cpython_wrapper(self, release_gil: bool = False) -> None:
        """In place of what unpacks Python's arguments: a function that refuses them."""
        module = self.context.create_module("refusal")
        api_type = self.context.get_argument_type(types.pyobject)
        form = ir.FunctionType(api_type, [api_type] * 3)
        wrapper = ir.Function(module, form, self.fndesc.llvm_cpython_wrapper_name)
        builder = ir.IRBuilder(wrapper.append_basic_block())
        api = self.context.get_python_api(builder)
        words = f"{self.fndesc.qualname}: only compiled functions can call it"
        api.err_set_string("PyExc_TypeError", words)
        builder.ret(api.get_null_object())
        self.library.add_ir_module(module)


@_registered
class WideLowering(NativeLowering):
    """Lowering for vectors of 512 bits."""

    _name = "wide_lowering"  # Numba's name for a pass

    @property
    def lowering_class(self) -> type[Lower]:
        """The class that writes a function's intermediate code."""
        return _WideLower


@_registered
class InnerLowering(WideLowering):
    """The same for a function that only compiled code calls."""

    _name = "inner_lowering"

    @property
    def lowering_class(self) -> type[Lower]:
        """The class that writes a function's intermediate code."""
        return _InnerLower


@_registered
class DisjointLowering(InnerLowering):
    """The same for one whose array arguments share no memory."""

    _name = "disjoint_lowering"

    def run_pass(self, state: Any) -> Any:
        """Lower the function of a compilation's state."""
        state.flags.noalias = True
        return super().run_pass(state)  # type: ignore[no-untyped-call]


class WideCompiler(CompilerBase):
    """Numba's compiler with wide vectors: the argument `pipeline_class` of `numba.njit`."""

    lowering: ClassVar[type[NativeLowering]] = WideLowering

    def define_pipelines(self) -> list[PassManager]:
        """Numba's own passes, in their order, with our lowering in place of Numba's."""
        prepare()  # should nobody have asked for it: what is compiled next is kept at least
        usual: Any = DefaultPassBuilder.define_nopython_pipeline(self.state)  # type: ignore[no-untyped-call]
        ours = PassManager("wide")  # type: ignore[no-untyped-call]
        for each, description in usual.passes:
            chosen = self.lowering if each is NativeLowering else each
            ours.add_pass(chosen, description)  # type: ignore[no-untyped-call]
        ours.finalize()  # type: ignore[no-untyped-call]
        return [ours]


class InnerCompiler(WideCompiler):
    """The same for a function that only compiled code calls."""

    lowering = InnerLowering


class DisjointCompiler(WideCompiler):
    """The same for one whose array arguments share no memory."""

    lowering = DisjointLowering


@contextmanager
def without_garbage_collection() -> Iterator[None]:
    """Switch Python's garbage collector off within the context.

    A compiler makes millions of objects that stay alive. Each collection visits all of them, which
    takes a tenth of the time. Without it, 100 MB more are in use until the context is left.
    """
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
