"""What an ONNX operator of one output is in the NumPy backend: a function of arrays."""

from collections.abc import Callable, Mapping
from typing import Any, TypeAlias

import numpy.typing as npt

Tensor: TypeAlias = npt.NDArray[Any]
Attributes: TypeAlias = Mapping[str, Any]
Operator: TypeAlias = Callable[..., Tensor]
Maker: TypeAlias = Callable[[Attributes], Operator]
"""Makes the function of a node from its attributes."""


def plain(operator: Operator) -> Maker:
    """The maker of an operator that has no attributes."""
    return lambda _: operator
