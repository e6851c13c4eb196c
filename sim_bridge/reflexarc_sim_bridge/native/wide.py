"""Vectors of 512 bits, where the processor has them.

LLVM takes half of them unless a function asks for more, from the days when whole ones made the
clock slower for everything else. A tile of sixteen rays is one such vector; a look takes a sixth
less time.
"""

from typing import Any

from numba.core.compiler_machinery import register_pass
from numba.core.lowering import Lower
from numba.core.typed_passes import NativeLowering

_registered: Any = register_pass(mutates_CFG=True, analysis_only=False)  # type: ignore[no-untyped-call]
_WIDE = '"prefer-vector-width"="512"'


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
