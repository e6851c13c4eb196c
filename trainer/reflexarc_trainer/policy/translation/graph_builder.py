"""An ONNX graph under construction, and what a rule of its translation is given.

A rule writes one call of the traced module as ONNX nodes. It is given a `Call` and returns the
names of the call's outputs: one, or a tuple of them where the call returns a tuple.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
import onnx
from onnx import helper, numpy_helper

from reflexarc_runtime.errors import PolicyError

Names: TypeAlias = "str | tuple[Names, ...]"


class Shape(tuple[int | None, ...]):
    """Sizes of a tensor; None is the size of the batch."""

    __slots__ = ()


@dataclass(frozen=True)
class Value:
    """A tensor of the graph: its name and its shape."""

    name: str
    shape: Shape


@dataclass
class Translation:
    """An ONNX graph under construction."""

    nodes: list[onnx.NodeProto] = field(default_factory=list)
    constants: list[onnx.TensorProto] = field(default_factory=list)
    is_exact: bool = True
    """Whether float32, in which the file holds them, has all the numbers of the module's code."""

    def node(self, kind: str, inputs: list[str], output: str = "", **attributes: Any) -> str:
        """Add a node of an ONNX operator (`kind`); returns the name of its output."""
        output = output or f"{kind.lower()}_{len(self.nodes)}"
        self.nodes.append(helper.make_node(kind, inputs, [output], name=output, **attributes))
        return output

    def many(self, kind: str, inputs: list[str], count: int, **attributes: Any) -> tuple[str, ...]:
        """Add a node of several outputs; returns their names."""
        name = f"{kind.lower()}_{len(self.nodes)}"
        outputs = tuple(f"{name}_{index}" for index in range(count))
        self.nodes.append(helper.make_node(kind, inputs, outputs, name=name, **attributes))
        return outputs

    def constant(self, name: str, value: npt.NDArray[Any]) -> str:
        """Add a constant; returns its name."""
        name = f"{name}_{len(self.constants)}"
        self.constants.append(numpy_helper.from_array(value, name))
        return name

    def integers(self, name: str, *values: int) -> str:
        """Add a constant of whole numbers, (values,); returns its name."""
        return self.constant(name, np.array(values, np.int64))

    def number(self, value: float) -> str:
        """Add a number out of the module's code, as float32 has it; returns its name."""
        return self.constant("number", np.array(self.rounded(value), np.float32))

    def rounded(self, value: float) -> float:
        """A number as float32 has it."""
        known = float(np.float32(value))
        self.is_exact = self.is_exact and known == value
        return known

    def named(self, argument: Any) -> str:
        """The name of an argument of a call: of a tensor, or of a number that is added.

        Raises:
            PolicyError: it is neither.
        """
        if isinstance(argument, Value):
            return argument.name
        if not isinstance(argument, int | float):
            said = "a number that depends on the size of the batch"
            what = said if type(argument).__name__ == "_Varies" else f"a {type(argument).__name__}"
            raise PolicyError(f"export: {what} is not supported as a tensor")
        return self.number(argument)

    def prune(self, outputs: list[str]) -> None:
        """Drop the nodes and constants that no output needs."""
        needed, kept = set(outputs), []
        for node in reversed(self.nodes):
            if needed.intersection(node.output):
                needed.update(node.input)
                kept.append(node)
        self.nodes = kept[::-1]
        self.constants = [tensor for tensor in self.constants if tensor.name in needed]


@dataclass(frozen=True)
class Call:
    """One call in the traced module."""

    graph: Translation
    module: Any
    """The torch module that is called; None where it is a function or a method."""
    args: list[Any]
    """Tensors as `Value`, numbers as they are."""
    kwargs: Mapping[str, Any]
    result: Any
    """Shape of what it returns; a tuple of shapes where it returns a tuple."""

    def given(self, *names: str, **defaults: Any) -> dict[str, Any]:
        """Arguments after the first by name, whether given by position or keyword.

        Args:
            names: the names, in the order of the positions.
            defaults: values of those that were not given.

        Raises:
            PolicyError: there are others.
        """
        known = dict(zip(names, self.args[1:], strict=False)) | dict(self.kwargs)
        others = known.keys() - set(names)
        if others or len(self.args) > 1 + len(names):
            raise PolicyError(f"export: arguments {', '.join(sorted(others))} are not supported")
        return defaults | known

    def options(self, *names: str, **defaults: Any) -> dict[str, Any]:
        """The same, or the module's attributes of these names where a module is called."""
        if self.module is not None:
            return {name: getattr(self.module, name) for name in names}
        if "inplace" not in names:
            defaults = {"inplace": False, **defaults}
            return self.given(*names, "inplace", **defaults)
        return self.given(*names, **defaults)


Rule: TypeAlias = Callable[[Call], Names]
