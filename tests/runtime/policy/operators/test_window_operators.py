"""Where a window's padding goes if it does not divide evenly: against onnxruntime."""

import numpy as np
import pytest
from onnx import helper

from support.onnx_nodes import Array, by_numpy, by_onnxruntime

IMAGE = np.random.default_rng(1).normal(size=(2, 1, 7, 6)).astype(np.float32)
KERNEL = np.random.default_rng(2).normal(size=(1, 1, 2, 3)).astype(np.float32)


@pytest.mark.parametrize("kind", ["AveragePool", "Conv", "MaxPool"])
@pytest.mark.parametrize("strides", [[1, 1], [2, 3], [3, 2]])
@pytest.mark.parametrize("side", ["SAME_LOWER", "SAME_UPPER", "VALID"])
def test_padding_by_itself(kind: str, strides: list[int], side: str) -> None:
    inputs: list[Array | None] = [IMAGE, KERNEL] if kind == "Conv" else [IMAGE]
    names = ["x", "w"][: len(inputs)]
    ways = {"kernel_shape": [2, 3], "strides": strides, "auto_pad": side}
    node = helper.make_node(kind, names, ["y"], **ways)
    (got,), (expected,) = by_numpy(node, inputs), by_onnxruntime(node, inputs)
    assert got.shape == expected.shape
    np.testing.assert_allclose(got, expected, rtol=1e-5, atol=1e-5)
