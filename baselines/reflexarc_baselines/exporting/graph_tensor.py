"""A stand-in for a NumPy array that writes down, as ONNX nodes, what is computed with it.

A baseline is written once, in NumPy. When its `decide` is run on stand-ins, NumPy hands every
function that it is asked for to them: its protocols for that are `__array_ufunc__` (NEP 13) and
`__array_function__` (NEP 18). So the code that is exported is the code that decides.

Each stand-in also carries the result for an example, a batch of one: from that come shapes and
kinds of numbers, by NumPy's own rules. Arrays that the code makes for a batch of one broadcast to
any batch. What would have to be known about the values (a branch, a loop, an assignment) is not
written down, but refused; what goes wrong all the same, the check of the file finds.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NoReturn, TypeAlias

import numpy as np
import numpy.typing as npt
import onnx
from numpy.lib.mixins import NDArrayOperatorsMixin

from reflexarc_runtime.errors import PolicyError
from reflexarc_trainer.policy.translation.graph_builder import Translation

Array: TypeAlias = npt.NDArray[Any]
Rule: TypeAlias = Callable[..., Any]
"""(scribe, *arguments of the NumPy function) → stand-ins."""


@dataclass(frozen=True)
class GraphScribe:
    """The graph that is being written, and the rules by which NumPy's functions become nodes."""

    graph: Translation
    ufuncs: Mapping[Any, Rule]
    functions: Mapping[Any, Rule]

    @cached_property
    def zeros(self) -> "GraphTensor":
        """As many zeros as there are agents: (1,) for the example."""
        byte = self.graph.node("Cast", ["retina"], to=onnx.TensorProto.FLOAT)
        flat = self.graph.node("Flatten", [byte])
        first = [flat, *(self.integers(i) for i in (0, 1, 1))]
        row = self.graph.node("Squeeze", [self.graph.node("Slice", first), self.integers(1)])
        zero = self.graph.node("Mul", [row, self.name_of(np.float32(0.0))])
        return self.tensor(zero, np.zeros(1, np.float32))

    def tensor(self, name: str, example: Array) -> "GraphTensor":
        """The stand-in for a value of the graph."""
        return GraphTensor(self, name, example)

    def node(self, kind: str, inputs: Sequence[str], example: Any, **attributes: Any) -> Any:
        """Add a node; the stand-in for its output."""
        name = self.graph.node(kind, list(inputs), **attributes)
        return GraphTensor(self, name, np.asarray(example))

    def name_of(self, value: Any, dtype: Any = None) -> str:
        """The name of a stand-in, or of a constant; floats are float32, integers int64.

        Args:
            value: a stand-in, an array or a number.
            dtype: what a constant shall be, where its operator has another input of that kind.
        """
        if isinstance(value, GraphTensor):
            return value.name
        array = np.asarray(value)
        if dtype is None:
            dtype = {"f": np.float32, "b": np.bool_}.get(array.dtype.kind, np.int64)
        return self.graph.constant("number", array.astype(dtype))

    def integers(self, *values: int) -> str:
        """The name of a constant (values,)."""
        return self.graph.integers("places", *values)


class GraphTensor(NDArrayOperatorsMixin):
    """Stands for a value of the graph."""

    def __init__(self, scribe: GraphScribe, name: str, example: Array) -> None:
        self.scribe, self.name, self.example = scribe, name, example

    @property
    def shape(self) -> tuple[int, ...]:
        """For a batch of one."""
        return self.example.shape

    @property
    def dtype(self) -> np.dtype[Any]:
        """As NumPy would have it."""
        return self.example.dtype

    @property
    def ndim(self) -> int:
        """Number of axes."""
        return self.example.ndim

    def __len__(self) -> int:
        return len(self.example)

    def __array_ufunc__(self, ufunc: Any, method: str, *inputs: Any, **options: Any) -> Any:
        rule = self.scribe.ufuncs.get(ufunc if method == "__call__" else (ufunc, method))
        if rule is None:
            refuse(f"numpy.{ufunc.__name__}" + ("" if method == "__call__" else f".{method}"))
        if options.get("out") is not None or "where" in options:
            refuse(f"numpy.{ufunc.__name__} into an array that is there already")
        others = {k: v for k, v in options.items() if k != "dtype"}
        return rule(self.scribe, *inputs, **others)

    def __array_function__(self, function: Any, _: Any, args: Any, options: Any) -> Any:
        rule = self.scribe.functions.get(function)
        if rule is None:
            refuse(f"numpy.{function.__name__}")
        return rule(self.scribe, *args, **options)

    def _method(self, function: Any, *args: Any, **options: Any) -> Any:
        return self.__array_function__(function, (), (self, *args), options)

    def sum(self, axis: int | None = None, dtype: Any = None) -> Any:
        """See `numpy.sum`."""
        return self._method(np.sum, axis=axis, dtype=dtype)

    def mean(self, axis: int | None = None, dtype: Any = None) -> Any:
        """See `numpy.mean`."""
        return self._method(np.mean, axis=axis, dtype=dtype)

    def max(self, axis: int | None = None) -> Any:
        """See `numpy.max`."""
        return self._method(np.max, axis=axis)

    def min(self, axis: int | None = None) -> Any:
        """See `numpy.min`."""
        return self._method(np.min, axis=axis)

    def any(self, axis: int | None = None) -> Any:
        """See `numpy.any`."""
        return self._method(np.any, axis=axis)

    def all(self, axis: int | None = None) -> Any:
        """See `numpy.all`."""
        return self._method(np.all, axis=axis)

    def argmax(self, axis: int) -> Any:
        """See `numpy.argmax`."""
        return self._method(np.argmax, axis=axis)

    def argmin(self, axis: int) -> Any:
        """See `numpy.argmin`."""
        return self._method(np.argmin, axis=axis)

    def reshape(self, *shape: Any) -> Any:
        """See `numpy.reshape`."""
        return self._method(np.reshape, shape[0] if isinstance(shape[0], tuple) else shape)

    def copy(self) -> "GraphTensor":
        """Itself: nothing changes a stand-in."""
        return self

    def astype(self, dtype: Any, copy: bool = True) -> "GraphTensor":
        """See `numpy.ndarray.astype`; float64 is float32 in a graph."""
        example = self.example.astype(dtype)
        if kind_of(example.dtype) == kind_of(self.dtype):
            return GraphTensor(self.scribe, self.name, example)
        made: GraphTensor = self.scribe.node(
            "Cast", [self.name], example, to=kind_of(example.dtype)
        )
        return made

    def __getitem__(self, index: Any) -> Any:
        return self._method(np.ndarray.__getitem__, index)

    def __setitem__(self, index: Any, value: Any) -> NoReturn:
        refuse("an assignment to elements")

    def __bool__(self) -> bool:
        refuse("a branch on a value")

    def __index__(self) -> int:
        refuse("a value as the index of an array")

    def __array__(self, dtype: Any = None, copy: Any = None) -> Array:
        refuse("a NumPy function that asks for the numbers themselves")


def kind_of(dtype: np.dtype[Any]) -> int:
    """What a kind of number is in ONNX."""
    kinds = onnx.TensorProto
    if dtype == np.uint8:
        return int(kinds.UINT8)
    return int({"f": kinds.FLOAT, "b": kinds.BOOL}.get(dtype.kind, kinds.INT64))


def refuse(what: str) -> NoReturn:
    """Refuse what has no node.

    Raises:
        PolicyError: always.
    """
    raise PolicyError(f"{what} cannot be written as a graph")
