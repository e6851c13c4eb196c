"""A tuple in compiled code by its address: each of its parts is read where it is used.

Numba hands a tuple on by value, word by word. Of the two hundred words that describe all arrays of
a simulation a step uses a few at a time; loading all of them at every call, only to put them on the
stack, took 150 ns.
"""

from typing import Any

import numpy as np
import numpy.typing as npt
from numba.core import cgutils, types
from numba.core.datamodel import models
from numba.core.typing.templates import AttributeTemplate
from numba.extending import infer_getattr, lower_getattr_generic, register_model


class Reference(types.Type):
    """Type of an address at which a named tuple lies."""

    def __init__(self, dtype: Any) -> None:
        self.dtype = dtype
        super().__init__(name=f"reference({dtype})")

    def part(self, name: str) -> Any:
        """Type of a field: again a reference, where that is a named tuple."""
        part = self.dtype[self.dtype.fields.index(name)]
        return Reference(part) if isinstance(part, types.BaseNamedTuple) else part


register_model(Reference)(models.PointerModel)


@infer_getattr  # numba finds it by its key
class _Parts(AttributeTemplate):
    key = Reference

    def generic_resolve(self, value: Any, attr: str) -> Any:  # type: ignore[override]
        """Type of `value.attr`, a `Reference`'s; None if there is no such field."""
        return value.part(attr) if attr in value.dtype.fields else None


def _load_part(context: Any, builder: Any, reference: Reference, address: Any, name: str) -> Any:
    part = reference.part(name)
    at = _gep(builder, address, 0, reference.dtype.fields.index(name))
    if isinstance(part, Reference):
        return at
    return context.data_model_manager[part].load_from_data_pointer(builder, at)


def laid_out(value: Any) -> npt.NDArray[np.void]:
    """A named tuple as compiled code has it in memory: by the rules of C, ().

    It shares the memory of its arrays and does not keep them.
    """
    form, parts = _layout(value)
    return np.array(parts, form)


def _layout(value: Any) -> tuple[np.dtype[Any], Any]:
    if isinstance(value, np.ndarray):
        # Behind two addresses for counting references, which borrowed arrays do without.
        words = [0, 0, value.size, value.itemsize, value.ctypes.data, *value.shape, *value.strides]
        return np.dtype((np.int64, len(words))), words
    if hasattr(value, "_fields"):
        forms, parts = zip(*map(_layout, value), strict=True)
        return np.dtype(list(zip(value._fields, forms, strict=True)), align=True), parts
    if not isinstance(value, bool | int | float | np.generic):
        raise TypeError(f"laid_out: expected arrays, numbers and named tuples, got {type(value)}")
    return np.dtype(type(value)), value


_gep: Any = cgutils.gep_inbounds
_lowered: Any = lower_getattr_generic
_lowered(Reference)(_load_part)
