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


class WideCompiler(Compiler):
    """Numba's compiler (an argument `pipeline_class` of its), for functions with wide vectors."""

    def define_pipelines(self) -> list[PassManager]:
        """The usual passes, but for the one that writes LLVM's code."""
        pipelines: list[PassManager] = super().define_pipelines()  # type: ignore[no-untyped-call]
        for pipeline in pipelines:
            pipeline.passes = [
                (_WideLowering if each is NativeLowering else each, why)
                for each, why in pipeline.passes
            ]
            pipeline.finalize()  # type: ignore[no-untyped-call]
        return pipelines


class _WideLower(Lower):
    def setup_function(self, fndesc: object) -> None:
        super().setup_function(fndesc)  # type: ignore[no-untyped-call]
        # Its own `add` knows no attributes with values.
        set.add(self.function.attributes, _WIDE)


@_registered
class _WideLowering(NativeLowering):
    _name = "wide_lowering"

    @property
    def lowering_class(self) -> type[Lower]:
        return _WideLower
