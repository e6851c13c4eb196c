"""Functions that only other compiled ones call: parts of these, and never machine code themselves.

Numba writes machine code for every function, also for those that end up within their callers and
are never entered: a tenth of the time that the world takes to compile. They are optimised all the
same: left to their callers, their loops become slower code.
"""

from typing import Any

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler_machinery import PassManager, register_pass

from reflexarc_sim_bridge.wide import WideCompiler, WideLowering, with_lowering

_registered: Any = register_pass(mutates_CFG=True, analysis_only=False)  # type: ignore[no-untyped-call]


class _NoMachineCode:
    """In the place of what holds the machine code of a function."""

    def set_env(self, name: str, environment: object) -> None:
        """Where Python's objects would be that the machine code uses: it uses none."""


class _LinkedLibrary(JITCodeLibrary):
    """LLVM's code of one function, for others to take in."""

    @property
    def codegen(self) -> _NoMachineCode:
        """Asked for where a function is made ready to run."""
        return _NoMachineCode()

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()  # type: ignore[no-untyped-call]
        self._verify_declare_only_symbols()  # type: ignore[no-untyped-call]
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Nowhere: it has no machine code."""
        return 0

    def serialize_using_object_code(self) -> Any:
        """What the cache keeps of it."""
        return self.serialize_using_bitcode()  # type: ignore[no-untyped-call]


@_registered
class _LinkedLowering(WideLowering):
    _name = "linked_lowering"

    def run_pass(self, state: Any) -> Any:
        codegen, name = state.targetctx.codegen(), state.func_id.func_qualname
        state.library = _LinkedLibrary(codegen, name)  # type: ignore[no-untyped-call]
        return super().run_pass(state)  # type: ignore[no-untyped-call]


class LinkedCompiler(WideCompiler):
    """Numba's compiler (an argument `pipeline_class` of its), for functions within others."""

    def define_pipelines(self) -> list[PassManager]:
        """The usual passes, but for the one that writes LLVM's code."""
        return with_lowering(super().define_pipelines(), WideLowering, _LinkedLowering)


LINKED: dict[str, Any] = {"no_cpython_wrapper": True, "pipeline_class": LinkedCompiler}
"""Options of numba's `njit` for such a function."""


def refuse_python(dispatcher: Any) -> None:
    """Let a call from Python raise: without machine code it would end the process."""

    def refuse(*_: object) -> None:
        raise TypeError(f"{dispatcher.__name__}: only compiled functions can call it")

    dispatcher._insert = lambda *_, **__: None  # Python's table of compiled forms stays empty
    dispatcher._compile_for_args = refuse
