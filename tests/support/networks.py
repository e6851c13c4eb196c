"""Changes to an exported policy: a weight here, its golden vectors there."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import onnx
from onnx import numpy_helper

from reflexarc_runtime.contract.golden import GoldenVectors
from reflexarc_runtime.policy.model_file import with_contract
from reflexarc_runtime.policy.policy import load_policy


def with_weights(
    policy: bytes, name: str, change: Callable[[npt.NDArray[np.float32]], None]
) -> bytes:
    """The same file with one array of weights changed; its golden vectors no longer hold."""
    model = onnx.ModelProto.FromString(policy)
    (tensor,) = [t for t in model.graph.initializer if t.name == name]
    array = numpy_helper.to_array(tensor).copy()
    change(array)
    tensor.CopyFrom(numpy_helper.from_array(array, name))
    return model.SerializeToString(deterministic=True)


def with_honest_vectors(policy: bytes) -> bytes:
    """The same file with the golden vectors that its weights give."""
    loaded = load_policy(policy, verify=False)
    golden, retina = loaded.contract.golden, loaded.contract.retina
    stacks = np.array(golden.retinas, np.uint8).reshape(-1, *retina.stack_shape)
    q_values, actions = loaded.decide(stacks)
    honest = GoldenVectors(
        retinas=golden.retinas,
        q_values=tuple(tuple(row) for row in q_values.tolist()),
        actions=tuple(actions.tolist()),
    )
    return with_contract(policy, replace(loaded.contract, golden=honest))
