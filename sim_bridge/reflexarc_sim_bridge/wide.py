"""Vectors of 512 bits, where the processor has them.

LLVM takes half of them unless a function asks for more, from the days when whole ones made the
clock slower for everything else. A tile of sixteen rays is one such vector; a look takes a sixth
less time.
"""

from typing import Any

from numba.core.compiler import Compiler
from numba.core.compiler_machinery import PassManager, register_pass
from numba.core.lowering import Lower
from numba.core.typed_passes import NativeLowering

_registered: Any = register_pass(mutates_CFG=True, analysis_only=False)  # type: ignore[no-untyped-call]
_WIDE = '"prefer-vector-width"="512"'


def with_lowering(
    pipelines: list[PassManager], usual: type[NativeLowering], ours: type[NativeLowering]
) -> list[PassManager]:
    """The same passes, but for the one that writes LLVM's code."""
    for pipeline in pipelines:
        pipeline.passes = [(ours if each is usual else each, why) for each, why in pipeline.passes]
        pipeline.finalize()  # type: ignore[no-untyped-call]
    return pipelines


class WideCompiler(Compiler):
    """Numba's compiler (an argument `pipeline_class` of its), for functions with wide vectors."""

    def define_pipelines(self) -> list[PassManager]:
        """The usual passes, but for the one that writes LLVM's code."""
        pipelines: list[PassManager] = super().define_pipelines()  # type: ignore[no-untyped-call]
        return with_lowering(pipelines, NativeLowering, WideLowering)


class _WideLower(Lower):
    def setup_function(self, fndesc: object) -> None:
        super().setup_function(fndesc)  # type: ignore[no-untyped-call]
        # Its own `add` knows no attributes with values.
        set.add(self.function.attributes, _WIDE)


@_registered
class WideLowering(NativeLowering):
    """The pass that writes LLVM's code, for wide vectors."""

    _name = "wide_lowering"

    @property
    def lowering_class(self) -> type[Lower]:
        """What writes it."""
        return _WideLower
