"""Policies with a memory for the runtime's tests, made without a trainer."""

import dataclasses

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.contract.golden import GoldenSequence, GoldenVectors
from reflexarc_runtime.contract.state_spec import StateSpec
from reflexarc_runtime.policy.golden_check import Graph, start_of
from reflexarc_runtime.policy.model_file import with_contract
from reflexarc_runtime.policy.policy import load_policy

UNITS = 5
REMEMBERING = PolicyContract(
    retina=RetinaSpec(rays=4),
    state=StateSpec(UNITS, (0.5, -0.5, 0.0, 0.25, 1.0)),
    q_tolerance=1e-5,
)
STEPS = 12


def gru_network(seed: int = 0) -> bytes:
    """An ONNX GRU of random weights, without a contract."""
    rng, inputs, actions = np.random.default_rng(seed), 4, 3
    shapes = {
        "w": (1, 3 * UNITS, inputs),
        "r": (1, 3 * UNITS, UNITS),
        "b": (1, 6 * UNITS),
        "head": (actions, UNITS),
    }
    weights = {name: rng.normal(size=shape).astype(np.float32) for name, shape in shapes.items()}
    constants = {"scale": np.array(255.0, np.float32), "first": np.array([0]), **weights}
    nodes = [
        helper.make_node("Cast", ["retina"], ["seen"], to=TensorProto.FLOAT),
        helper.make_node("Div", ["seen", "scale"], ["intensity"]),
        helper.make_node("Flatten", ["intensity"], ["flat"], axis=1),
        helper.make_node("Unsqueeze", ["flat", "first"], ["x"]),
        helper.make_node("Unsqueeze", ["state", "first"], ["h"]),
        helper.make_node("GRU", ["x", "w", "r", "b", "", "h"], ["", "end"], hidden_size=UNITS),
        helper.make_node("Squeeze", ["end", "first"], ["state_next"]),
        helper.make_node("Gemm", ["state_next", "head"], ["q_values"], transB=1),
        helper.make_node("ArgMax", ["q_values"], ["action"], axis=1, keepdims=0),
    ]
    info = helper.make_tensor_value_info
    graph = helper.make_graph(
        nodes,
        "policy",
        [
            info("retina", TensorProto.UINT8, ["N", *REMEMBERING.retina.stack_shape]),
            info("state", TensorProto.FLOAT, ["N", UNITS]),
        ],
        [
            info("q_values", TensorProto.FLOAT, ["N", actions]),
            info("action", TensorProto.INT64, ["N"]),
            info("state_next", TensorProto.FLOAT, ["N", UNITS]),
        ],
        [numpy_helper.from_array(array, name) for name, array in constants.items()],
    )
    opset = [helper.make_opsetid("", 17)]
    model = helper.make_model(graph, opset_imports=opset, ir_version=8)
    onnx.checker.check_model(model, full_check=True)
    return model.SerializeToString()


def remembering_policy(seed: int = 0) -> bytes:
    """The same with a contract, golden vectors and a golden sequence."""
    model = with_contract(gru_network(seed), REMEMBERING)
    graph = load_policy(model, verify=False).graph
    return with_contract(model, dataclasses.replace(REMEMBERING, golden=_golden(graph, seed)))


def _golden(graph: Graph, seed: int) -> GoldenVectors:
    shape = (STEPS, *REMEMBERING.retina.stack_shape)
    stacks = np.random.default_rng(seed).integers(0, 256, shape, np.uint8)
    q_values, actions, _ = graph.run(stacks, start_of(REMEMBERING, STEPS))
    rows = tuple(map(tuple, stacks.reshape(STEPS, -1).tolist()))
    memories, values, winners = start_of(REMEMBERING, 1), [], []
    for stack in stacks[:, np.newaxis]:
        q, action, memories = graph.run(stack, memories)
        values.append(tuple(q[0].tolist()))
        winners.append(int(action[0]))
    assert memories is not None
    sequence = GoldenSequence(rows, tuple(values), tuple(winners), tuple(memories[0].tolist()))
    return GoldenVectors(
        rows, tuple(map(tuple, q_values.tolist())), tuple(actions.tolist()), (sequence,)
    )
