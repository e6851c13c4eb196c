"""Functions that only other compiled ones call: parts of these, and never machine code themselves.

Numba writes machine code for every function, also for those that end up within their callers and
are never entered: a tenth of the time that the world takes to compile. They are optimised all the
same: left to their callers, their loops become slower code.
"""

from collections.abc import Callable
from typing import Any

import numba
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler_machinery import register_pass

from reflexarc_sim_bridge.native.lean import LeanCompiler
from reflexarc_sim_bridge.native.wide import WideLowering

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


class LinkedCompiler(LeanCompiler):
    """Numba's compiler (an argument `pipeline_class` of its), for functions within others."""

    lowering = _LinkedLowering


class _LinkedCacheImpl(CompileResultCacheImpl):
    def rebuild(self, target_context: Any, payload: Any) -> Any:
        """What was kept, again without machine code."""
        codegen = target_context.codegen()
        codegen._library_class = _LinkedLibrary
        try:
            return super().rebuild(target_context, payload)  # type: ignore[no-untyped-call]
        finally:
            del codegen._library_class  # that of its class counts again


class _LinkedCache(FunctionCache):
    _impl_class = _LinkedCacheImpl

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """What was kept for these types: two processes that write at once may have mixed it up."""
        kept = super().load_overload(sig, target_context)  # type: ignore[no-untyped-call]
        return kept if kept is None or kept.signature.args == tuple(sig) else None


def linked(function: Callable[..., Any], **options: Any) -> Any:
    """Compile it by numba's `njit` with these options, as a part of whoever calls it.

    A call from Python raises: without machine code it would end the process.
    """

    def refuse(*_: object) -> None:
        raise TypeError(f"{function.__name__}: only compiled functions can call it")

    njit: Any = numba.njit  # its stub does not know all of its options
    usual = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "error_model": "numpy"}
    dispatcher = njit(pipeline_class=LinkedCompiler, _nrt=False, **usual, **options)(function)
    dispatcher._cache = _LinkedCache(function)  # type: ignore[no-untyped-call]
    dispatcher._insert = lambda *_, **__: None  # Python's table of compiled forms stays empty
    dispatcher._compile_for_args = refuse
    return dispatcher
