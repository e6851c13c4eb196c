"""Every ONNX operator of the NumPy backend, against onnxruntime."""

import re
from pathlib import Path

import numpy as np
import onnx
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from onnx import helper

from reflexarc_runtime.policy.numpy_limits import Meter
from reflexarc_runtime.policy.operators.operator_table import compiled, supported_operators
from support.onnx_nodes import Array, by_numpy, by_onnxruntime, in_double
from support.operator_trials import TRIALS
from support.operator_trials.trial import Draw

MADE_BEFORE = ("Constant",)
"""What they make lies in the file; its size is bounded there."""
REPOSITORY = Path(__file__).parents[4]


def cost_of(node: onnx.NodeProto, opset: int, inputs: list[Array | None]) -> int:
    """How many numbers the NumPy backend expects a node to make."""
    meter = Meter(1 << 60, 1)
    meter.count(compiled(node, opset)[0], inputs)
    return meter.made


def test_every_operator_is_tried_and_no_other() -> None:
    assert set(TRIALS) == set(supported_operators())


def test_the_documentation_lists_them_all() -> None:
    listed = (REPOSITORY / "docs" / "networks.md").read_text().split("## Operators of")[1]
    assert tuple(re.findall(r"`([A-Z]\w+)`[,.]", listed)) == supported_operators()


@pytest.mark.parametrize("kind", sorted(TRIALS))
@given(data=st.data())
@settings(deadline=None, max_examples=20)
def test_an_operator_computes_what_onnxruntime_computes(kind: str, data: st.DataObject) -> None:
    trial = TRIALS[kind](Draw(data))
    names = [f"x{i}" if given is not None else "" for i, given in enumerate(trial.inputs)]
    outputs = [f"y{i}" for i in range(trial.outputs)]
    node = helper.make_node(kind, names, outputs, **trial.attributes)
    expected = by_onnxruntime(node, trial.inputs, trial.opset)
    got = by_numpy(node, trial.inputs, trial.opset)
    made = sum(array.size for array in got)
    assert cost_of(node, trial.opset, in_double(trial.inputs)) >= made or kind in MADE_BEFORE
    assert [array.shape for array in got] == [array.shape for array in expected]
    for mine, its in zip(got, expected, strict=True):
        assert mine.dtype == (np.float64 if its.dtype.kind == "f" else its.dtype)
        np.testing.assert_allclose(mine, its, rtol=trial.tolerance, atol=trial.tolerance)
