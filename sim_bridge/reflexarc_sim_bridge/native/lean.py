"""Numba's compiler with the passes that our functions need, and a memory for what it found out.

Of Numba's passes half are for closures, `with`, `literal_unroll` and branches on `None`, of which
there are none here; each takes its time in each of two hundred functions. And it asks anew, at
every `+`, some thirty rules which of them adds two integers. Without these two the world and its
learner compile in three quarters of the time, to the same code.
"""

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from types import BuiltinFunctionType
from typing import Any, ClassVar

from numba.core import types
from numba.core.compiler import CompilerBase
from numba.core.compiler_machinery import PassManager
from numba.core.typed_passes import (
    IRLegalization,
    NativeLowering,
    NoPythonBackend,
    NopythonRewrites,
    NopythonTypeInference,
    PreLowerStripPhis,
)
from numba.core.untyped_passes import (
    FixupArgs,
    GenericRewrites,
    InlineInlinables,
    IRProcessing,
    ReconstructSSA,
    TranslateByteCode,
)

from reflexarc_sim_bridge.native.wide import WideLowering


class LeanCompiler(CompilerBase):
    """Compiles plain functions (an argument `pipeline_class` of Numba's `njit`)."""

    lowering: ClassVar[type[NativeLowering]] = WideLowering
    """The pass that writes LLVM's code."""

    def __init__(self, rules: Any, *rest: Any) -> None:
        """As Numba's, whose rules of types come first."""
        super().__init__(_Remembered(rules), *rest)  # type: ignore[no-untyped-call]
        self.state.typingctx.allocates = self.state.flags.nrt

    def define_pipelines(self) -> list[PassManager]:
        """All passes, in one row."""
        passes: tuple[type, ...] = (
            *(TranslateByteCode, FixupArgs, IRProcessing, GenericRewrites),
            *(InlineInlinables, ReconstructSSA, NopythonTypeInference, PreLowerStripPhis),
            # Only what allocates has expressions over whole arrays, and none has texts as indices.
            *([NopythonRewrites] if self.state.flags.nrt else []),
            *(IRLegalization, self.lowering, NoPythonBackend),
        )
        row = PassManager("lean")  # type: ignore[no-untyped-call]
        for each in passes:
            row.add_pass(each, each.__name__)  # type: ignore[no-untyped-call]
        row.finalize()  # type: ignore[no-untyped-call]
        return [row]


class _Remembered:
    """Numba's rules of types; which of them fits a built-in function's arguments it asks once."""

    _found: ClassVar[dict[Any, Any]] = {}

    def __init__(self, rules: Any) -> None:
        self._rules = rules
        self.allocates = False
        """Part of the key: a rule may compile a function to fit, which counts arrays or does not.

        In its other flags such a function (`min`, `max`) may be as another of its callers asked.
        """

    def __getattr__(self, name: str) -> Any:
        return getattr(self._rules, name)

    def resolve_function_type(self, function: Any, args: Any, named: Any) -> Any:
        """The signature that a function has for such arguments, or None."""
        if named or not isinstance(function, types.Function | BuiltinFunctionType):
            return self._rules.resolve_function_type(function, args, named)
        key = function, tuple(args), self.allocates
        if key not in self._found:
            found = self._rules.resolve_function_type(function, args, named)
            if found is None:
                return None
            self._found[key] = found
        return self._found[key]


@contextmanager
def uncollected() -> Iterator[None]:
    """Within it nobody looks for garbage: a compiler makes millions of objects that are none.

    It takes a fifteenth less time, and 100 MB more until it is left.
    """
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
