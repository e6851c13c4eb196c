"""The reason in an error of onnxruntime, without the place in its source."""

import onnx
import pytest

from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.onnxruntime_refusal import refusal
from reflexarc_runtime.policy.policy import load_policy
from support.hostile_policies import POLICIES
from support.policies import SMALL, exported

HEAD = "[ONNXRuntimeError] : 1 : FAIL : "
MODEL = (
    "/onnxruntime_src/onnxruntime/core/graph/model.cc:256 onnxruntime::Model::Model("
    "onnx::ModelProto&&, const std::function<void(int)>&, const onnxruntime::ModelOptions&) "
)
CLIP = (
    "Exception during initialization: /onnxruntime_src/onnxruntime/core/math/clip.h:23 "
    "onnxruntime::Clip_6Base<T>::Clip_6Base(const onnxruntime::OpKernelInfo&) [with T = float] "
)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (HEAD + MODEL + "Unsupported model IR version: 14", "Unsupported model IR version: 14"),
        (HEAD + CLIP + "min was false.", "Exception during initialization: min was false."),
        (HEAD + "Node () Op (Add) has no type", "Node () Op (Add) has no type"),
        (HEAD + "/onnxruntime_src/a.cc:1 no signature", "no signature"),
        (HEAD + "/onnxruntime_src/a.cc:1 f::operator()(int) const too large", "too large"),
        ("a\x1b[31mb\nsecond", "a?[31mb"),
        ("", "RuntimeError"),
    ],
)
def test_the_reason_is_left(text: str, said: str) -> None:
    assert refusal(RuntimeError(text)) == said


def test_a_format_that_is_too_new_is_named() -> None:
    model = onnx.ModelProto.FromString(exported(SMALL))
    model.ir_version = 99
    with pytest.raises(PolicyError, match="Unsupported model IR version: 99, max supported"):
        load_policy(model.SerializeToString(), "onnxruntime")


def test_what_fails_when_it_runs_is_named_too() -> None:
    with pytest.raises(PolicyError, match="delta in Range operator can not be zero"):
        load_policy(POLICIES["a range by steps of 0"](), "onnxruntime")
