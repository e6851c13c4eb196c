"""What an ONNX operator is in the NumPy backend: a function of arrays, made from a node.

Floats are float64 there, whatever the file says; whole numbers and truths keep their type.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
import onnx
from onnx import TensorProto, numpy_helper

from reflexarc_runtime.errors import PolicyError

Tensor: TypeAlias = npt.NDArray[Any]
Operator: TypeAlias = Callable[..., Any]
"""From the inputs of a node to its output; to a tuple of them if it may have several."""

ABSENT = ""
"""How ONNX names an optional input that is not given, and an output that nobody wants."""
ONNX_DOMAINS = ("", "ai.onnx")
"""How it names its own operators."""
LATEST_OPSET = 26
"""The newest version of ONNX's operator set whose meanings are known here."""
OLDEST_OPSET = 7
"""Before it, elements were not broadcast as they are since."""

_FLOATS = (TensorProto.FLOAT, TensorProto.DOUBLE, TensorProto.FLOAT16, TensorProto.BFLOAT16)
_OTHERS = (
    TensorProto.BOOL,
    TensorProto.INT8,
    TensorProto.INT16,
    TensorProto.INT32,
    TensorProto.INT64,
    TensorProto.UINT8,
    TensorProto.UINT16,
    TensorProto.UINT32,
    TensorProto.UINT64,
)


@dataclass(frozen=True)
class OnnxNode:
    """One node of a graph, as the maker of its function sees it."""

    kind: str
    attributes: Mapping[str, Any] = field(default_factory=dict)
    inputs: tuple[str, ...] = ()
    outputs: tuple[str, ...] = ("",)
    opset: int = 17
    """Version of the operator set: what a missing attribute means hangs on it."""
    _read: set[str] = field(default_factory=set)

    @property
    def name(self) -> str:
        """What to call it: its last output."""
        return next(filter(None, reversed(self.outputs)), "")

    def __getitem__(self, name: str) -> Any:
        self._read.add(name)
        try:
            return self.attributes[name]
        except KeyError:
            raise PolicyError(f"operator {self.kind}: attribute '{name}' is missing") from None

    def get(self, name: str, default: Any = None) -> Any:
        """An attribute, or what it is where it is not given."""
        self._read.add(name)
        return self.attributes.get(name, default)

    def word(self, name: str, default: str) -> str:
        """An attribute that is a word."""
        value = self.get(name, default)
        return value.decode(errors="replace") if isinstance(value, bytes) else str(value)

    def passes_over(self, *names: str) -> None:
        """These attributes change nothing here."""
        self._read.update(names)

    def require(self, name: str, value: Any, why: str) -> None:
        """Refuse another value of an attribute than this one, its default."""
        given = self.get(name, value)
        if given != value:
            raise PolicyError(f"operator {self.kind}: {name}={given}; {why}")

    def unread(self) -> list[str]:
        """Names of attributes that nobody asked for: what they mean is not known."""
        return sorted(self.attributes.keys() - self._read)


Maker: TypeAlias = Callable[[OnnxNode], Operator]
"""Makes the function of a node."""


def plain(operator: Operator) -> Maker:
    """The maker of an operator that has no attributes."""
    return lambda _: operator


def array_of(tensor: onnx.TensorProto) -> Tensor:
    """The numbers of a tensor in a file.

    Raises:
        PolicyError: it holds something else than numbers and truths.
    """
    is_float = tensor.data_type in _FLOATS
    if not is_float and tensor.data_type not in _OTHERS:
        raise PolicyError(
            f"{tensor.name or 'a constant'!r} is of type {type_name(tensor)}, {_KNOWN}"
        )
    array: Tensor = numpy_helper.to_array(tensor)
    return array.astype(np.float64) if is_float else array


def type_name(tensor: onnx.TensorProto) -> str:
    """How ONNX calls the type of its elements."""
    known = TensorProto.DataType.values()
    return TensorProto.DataType.Name(tensor.data_type) if tensor.data_type in known else "unknown"


def caster(to: int) -> Operator:
    """What turns numbers into those of an ONNX type; floats of 16 bits are rounded to it."""
    if to in (TensorProto.FLOAT, TensorProto.DOUBLE):
        return lambda x: x.astype(np.float64)
    if to not in (*_FLOATS, *_OTHERS):
        raise PolicyError(f"operator Cast: to type {to}, {_KNOWN}")
    dtype = onnx.helper.tensor_dtype_to_np_dtype(to)
    if to in _FLOATS:
        return lambda x: x.astype(dtype).astype(np.float64)
    return lambda x: x.astype(dtype)


_KNOWN = "which is not in the NumPy backend; use --backend onnxruntime"
