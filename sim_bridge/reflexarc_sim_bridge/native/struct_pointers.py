"""Named tuples in compiled code by their address: each field is read where it is used.

Numba hands a tuple on by value, word by word. Of the two hundred words that describe all arrays of
a simulation a step uses a few at a time; loading all of them at every call, only to put them on the
stack, took 150 ns.
"""

import hashlib
from typing import Any, Self

import numpy as np
import numpy.typing as npt
from numba.core import cgutils, types
from numba.core.datamodel import models
from numba.core.typing.templates import AttributeTemplate
from numba.extending import (
    NativeValue,
    infer_getattr,
    lower_getattr_generic,
    register_model,
    typeof_impl,
    unbox,
)


class StructPointer(types.Type):
    """Type of an address at which a named tuple lies.

    Args:
        dtype: Numba's type of the named tuple.
    """

    def __init__(self, dtype: Any) -> None:
        self.dtype = dtype
        # Names become part of every function's own: that of all arrays of a simulation is 10 kB.
        digest = hashlib.sha256(str(dtype).encode()).hexdigest()[:16]
        super().__init__(name=f"{dtype.instance_class.__name__}*{digest}")

    @property
    def key(self) -> Any:
        """What tells two types apart."""
        return self.dtype

    def field(self, name: str) -> Any:
        """Type of a field: again an address, where that is a named tuple."""
        field = self.dtype[self.dtype.fields.index(name)]
        return StructPointer(field) if isinstance(field, types.BaseNamedTuple) else field


class AnyStruct(types.Type):
    """Type of an address at which a named tuple of a class lies, whatever arrays it holds.

    Compiled code can hand it on and do nothing else with it.

    Args:
        of: the class.
    """

    def __init__(self, of: type) -> None:
        self.of = of
        super().__init__(name=f"{of.__name__}*")

    @property
    def key(self) -> Any:
        """The class itself: two classes may have one name."""
        return self.of

    def takes(self, kind: Any) -> bool:
        """Whether such an address is of this class."""
        if isinstance(kind, StructPointer):
            return kind.dtype.instance_class is self.of
        return bool(kind == self)


class Struct:
    """A named tuple, laid out in memory as compiled code has it, by the rules of C.

    It shares the memory of the arrays and cannot be copied: it is what lies at its address.

    Args:
        value: arrays, numbers, function pointers, and named tuples of these.

    Raises:
        TypeError: it holds anything else.
    """

    def __init__(self, value: Any) -> None:
        self.value, self.of = value, type(value)
        self._memory = laid_out(value)
        self.address = self._memory.ctypes.data
        """Where it lies."""

    @classmethod
    def nowhere(cls, of: type) -> Self:
        """The address of nothing, for a call that compiles and touches nothing."""
        nothing = cls.__new__(cls)
        nothing.of, nothing.address = of, 0
        return nothing

    def __reduce__(self) -> Any:
        raise TypeError("Struct: expected to stay where its address is; make a new one")


def laid_out(value: Any) -> npt.NDArray[np.void]:
    """A named tuple as compiled code has it in memory, ().

    It shares the memory of its arrays and does not keep them.
    """
    form, fields = _layout(value)
    return np.array(fields, form)


def _layout(value: Any) -> tuple[np.dtype[Any], Any]:
    if isinstance(value, np.ndarray):
        # Behind two addresses for counting references, which borrowed arrays do without.
        words = [0, 0, value.size, value.itemsize, value.ctypes.data, *value.shape, *value.strides]
        return np.dtype((np.int64, len(words))), words
    if hasattr(value, "_fields"):
        forms, fields = zip(*map(_layout, value), strict=True)
        return np.dtype(list(zip(value._fields, forms, strict=True)), align=True), fields
    if hasattr(value, "address"):
        return np.dtype(np.int64), value.address
    if not isinstance(value, bool | int | float | np.generic):
        raise TypeError(f"laid_out: expected arrays, numbers and named tuples, got {type(value)}")
    return np.dtype(type(value)), value


register_model(StructPointer)(models.PointerModel)
register_model(AnyStruct)(models.OpaqueModel)


@infer_getattr  # numba finds it by its key
class _Fields(AttributeTemplate):
    key = StructPointer

    def generic_resolve(self, value: Any, attr: str) -> Any:  # type: ignore[override]
        """Type of `value.attr`; None if there is no such field."""
        return value.field(attr) if attr in value.dtype.fields else None


def _load_field(context: Any, builder: Any, kind: StructPointer, address: Any, name: str) -> Any:
    field = kind.field(name)
    at = _gep(builder, address, 0, kind.dtype.fields.index(name))
    if isinstance(field, StructPointer):
        return at
    return context.data_model_manager[field].load_from_data_pointer(builder, at)


@typeof_impl.register(Struct)
def _type_of_struct(struct: Struct, _: Any) -> AnyStruct:
    return AnyStruct(struct.of)


def address_from_python(thing: Any, c: Any) -> tuple[Any, Any]:
    """In LLVM's code: the attribute `address` of a Python object, and whether that failed.

    Args:
        thing: the object.
        c: what Numba gives to those that unbox.
    """
    address = c.pyapi.object_getattr_string(thing, "address")
    word = c.pyapi.long_as_longlong(address)
    c.pyapi.decref(address)
    return word, _is_not_null(c.builder, c.pyapi.err_occurred())


def _unbox_struct(_: Any, struct: Any, c: Any) -> Any:
    word, failed = address_from_python(struct, c)
    at = c.builder.inttoptr(word, c.context.get_value_type(types.voidptr))
    return _native_value(at, is_error=failed)


_gep: Any = cgutils.gep_inbounds
_is_not_null: Any = cgutils.is_not_null
_lowered: Any = lower_getattr_generic
_native_value: Any = NativeValue
_unboxed: Any = unbox
_lowered(StructPointer)(_load_field)
_unboxed(AnyStruct)(_unbox_struct)
