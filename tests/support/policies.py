"""Small policies for the runtime's tests: hand-written, and exported ones without a trainer."""

import dataclasses
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
import onnx
from onnx import TensorProto, helper, numpy_helper

from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.contract.golden import GoldenVectors
from reflexarc_runtime.policy.model_file import with_contract
from reflexarc_runtime.policy.policy import load_policy

SMALL = PolicyContract(retina=RetinaSpec(rays=4))


@dataclass
class ScriptedPolicy:
    """Says what it was told to say, and remembers what it was given."""

    q_values: tuple[float, ...] = (0.1, 0.9, 0.2)
    given: list[RetinaBatch] = field(default_factory=list)

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        self.given.append(retinas)
        q_values = np.tile(np.array(self.q_values, np.float32), (len(retinas), 1))
        return q_values, np.argmax(q_values, axis=1)


class FailingPolicy:
    """Raises whatever it is asked."""

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        raise RuntimeError("broken on purpose")


def network(
    contract: PolicyContract, seed: int = 0, hidden: int = 5, activation: str = "Sigmoid"
) -> bytes:
    """An ONNX network of random weights, without a contract."""
    rng = np.random.default_rng(seed)
    inputs, actions = contract.retina.frames * contract.retina.size, len(contract.actions)
    weights = {
        "scale": np.array(255.0, np.float32),
        "w1": rng.normal(size=(hidden, inputs)).astype(np.float32),
        "b1": rng.normal(size=hidden).astype(np.float32),
        "w2": rng.normal(size=(actions, hidden)).astype(np.float32),
        "b2": rng.normal(size=actions).astype(np.float32),
    }
    return _model(contract, weights, activation).SerializeToString()


def exported(contract: PolicyContract, seed: int = 0, activation: str = "Sigmoid") -> bytes:
    """The same with a contract and golden vectors, as the exporter leaves it."""
    model = network(contract, seed, activation=activation)
    rng = np.random.default_rng(seed + 1)
    stacks = rng.integers(0, 256, (8, *contract.retina.stack_shape), dtype=np.uint8)
    bare = load_policy(with_contract(model, contract), "onnxruntime", verify=False, bounds=None)
    q_values, actions = bare.decide(stacks)
    if activation in ("Sigmoid", "Relu", "Tanh"):
        bare = load_policy(with_contract(model, contract), verify=False, bounds=None)
        q_values, actions = bare.decide(stacks)
    return with_contract(
        model, dataclasses.replace(contract, golden=_golden(stacks, q_values, actions))
    )


def _golden(stacks: RetinaBatch, q_values: QValues, actions: Actions) -> GoldenVectors:
    return GoldenVectors(
        retinas=tuple(tuple(row) for row in stacks.reshape(len(stacks), -1).tolist()),
        q_values=tuple(tuple(row) for row in q_values.tolist()),
        actions=tuple(actions.tolist()),
    )


def _model(
    contract: PolicyContract, weights: dict[str, npt.NDArray[np.float32]], activation: str
) -> onnx.ModelProto:
    nodes = [
        helper.make_node("Cast", ["retina"], ["seen"], to=TensorProto.FLOAT),
        helper.make_node("Div", ["seen", "scale"], ["intensity"]),
        helper.make_node("Flatten", ["intensity"], ["inputs"], axis=1),
        helper.make_node("Gemm", ["inputs", "w1", "b1"], ["sums"], transB=1),
        helper.make_node(activation, ["sums"], ["hidden"]),
        helper.make_node("Gemm", ["hidden", "w2", "b2"], ["q_values"], transB=1),
        helper.make_node("ArgMax", ["q_values"], ["action"], axis=1, keepdims=0),
    ]
    graph = helper.make_graph(
        nodes,
        "policy",
        [
            helper.make_tensor_value_info(
                "retina", TensorProto.UINT8, ["N", *contract.retina.stack_shape]
            )
        ],
        [
            helper.make_tensor_value_info(
                "q_values", TensorProto.FLOAT, ["N", len(contract.actions)]
            ),
            helper.make_tensor_value_info("action", TensorProto.INT64, ["N"]),
        ],
        [numpy_helper.from_array(array, name) for name, array in weights.items()],
    )
    return helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
