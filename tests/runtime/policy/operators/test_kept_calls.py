"""Operators that write into kept arrays, against the same operators without: equal bits."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from onnx import helper

from reflexarc_runtime.policy.operators.kept_calls import KEPT, kept_calls
from reflexarc_runtime.policy.operators.operator_table import compiled
from support.onnx_nodes import Array, in_double
from support.operator_trials import TRIALS
from support.operator_trials.trial import Draw


def others_like(arrays: list[Array | None]) -> list[Array | None]:
    """Other numbers of the same shapes; whole numbers, which may say a shape, stay."""
    return [
        -np.roll(a, 1) if a is not None and a.dtype.kind == "f" and a.ndim else a for a in arrays
    ]


@pytest.mark.parametrize("kind", sorted(TRIALS))
@given(data=st.data())
@settings(deadline=None, max_examples=12)
def test_kept_arrays_hold_what_the_operator_returns(kind: str, data: st.DataObject) -> None:
    trial = TRIALS[kind](Draw(data))
    names = [f"x{i}" if given is not None else "" for i, given in enumerate(trial.inputs)]
    proto = helper.make_node(
        kind, names, [f"y{i}" for i in range(trial.outputs)], **trial.attributes
    )
    node, operator = compiled(proto, trial.opset)
    first = in_double(trial.inputs)[: len(node.inputs)]
    given = [None if array is None else array.copy() for array in first]
    with np.errstate(all="ignore"):
        kept, calls = kept_calls(operator, node, given)
        for inputs in (first, others_like(first), first):
            for array, new in zip(given, inputs, strict=True):
                if array is not None:
                    np.copyto(array, new)
            for call in calls:
                call()
            result = operator(*inputs)
            expected = result if isinstance(result, tuple) else (result,)
            assert [np.asarray(e).tobytes() for e in expected] == [k.tobytes() for k in kept]
            assert [np.asarray(e).dtype for e in expected] == [k.dtype for k in kept]


def test_every_operator_with_calls_of_its_own_is_one_of_the_backend() -> None:
    assert set(KEPT) <= set(TRIALS)
