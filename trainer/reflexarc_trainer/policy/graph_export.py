"""From a graph to a policy file: one self-describing ONNX file.

The file's graph holds everything between a retina's bytes and the greedy action:

    retina uint8 [N, frames, eyes, rays, channels] → … → q_values → argmax

and, for a policy with a memory, leads it through:

    state float32 [N, size] → … → state_next

The file's metadata hold the contract with golden vectors, golden sequences for a policy with a
memory, and the tolerance between backends that its weights need (`rounding_bound.py`). Nothing is
written unless the ONNX checker accepts the file, and what it was made from, the NumPy reference and
onnxruntime agree on it. The same graph and contract give the same bytes, for no date goes into
them.

Nothing here loads torch.
"""

import dataclasses
from pathlib import Path

import onnx

from reflexarc_runtime.arrays import RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.files import write_atomically
from reflexarc_runtime.policy.model_file import with_contract
from reflexarc_runtime.policy.numpy_backend import NumpyGraph
from reflexarc_trainer.policy.golden_vectors import golden_of
from reflexarc_trainer.policy.parity import Original, check_finite, check_model, check_parity
from reflexarc_trainer.policy.probes import Probes, probe_memories, reached_memories
from reflexarc_trainer.policy.rounding.rounding_bound import rounding_bound, tolerance_for
from reflexarc_trainer.policy.translation.graph_builder import Translation

OPSET = 17
IR_VERSION = 8
"""With opset 17 it is what runtimes since 2022 read."""


def export_graph(
    model: onnx.ModelProto,
    original: Original,
    contract: PolicyContract,
    path: Path,
    retinas: RetinaBatch,
) -> PolicyContract:
    """Write a model as a policy file.

    Args:
        model: what `finished` made, without a contract.
        original: what it was made from.
        contract: what the policy sees and does. Its golden vectors are replaced; its tolerance
            is raised where the weights need more.
        path: the file.
        retinas: to check it with: uint8 (n, frames, eyes, rays, channels).

    Returns:
        The contract as written, golden vectors included.

    Raises:
        PolicyError: the checker refuses the graph, or the backends do not agree. The file is then
            unchanged.
    """
    data = model.SerializeToString(deterministic=True)
    check_model(data)
    reference = NumpyGraph(model)
    probes = _probes(reference, contract, retinas)
    check_finite(reference, probes)
    bound = rounding_bound(model, probes)
    contract = dataclasses.replace(
        contract,
        q_tolerance=tolerance_for(bound, contract.q_tolerance),
        golden=golden_of(reference, contract, retinas),
    )
    data = with_contract(data, contract)
    check_parity(original, data, probes, bound)
    write_atomically(path, data)
    return contract


def finished(
    graph: Translation, q_values: str, state_next: str | None, contract: PolicyContract
) -> onnx.ModelProto:
    """The ONNX model of a graph, with the greedy action and without a contract.

    Args:
        graph: its nodes begin at `retina` and `state`. What no output needs is dropped.
        q_values: the name of the Q-values in it.
        state_next: the name of the next memories, if the contract has a memory.
        contract: whose shapes its inputs and outputs have.
    """
    graph.node("Identity", [q_values], "q_values")
    graph.node("ArgMax", ["q_values"], "action", axis=1, keepdims=0, select_last_index=0)
    if state_next is not None:
        graph.node("Identity", [state_next], "state_next")
    return _model(graph, contract)


def _probes(reference: NumpyGraph, contract: PolicyContract, retinas: RetinaBatch) -> Probes:
    """The inputs to check it with: memories beside the retinas, if it has one."""
    if not contract.state.size:
        return Probes(retinas, None)
    reached = reached_memories(reference, contract)
    return Probes(retinas, probe_memories(contract, reached, len(retinas)))


def _model(translation: Translation, contract: PolicyContract) -> onnx.ModelProto:
    info, kinds = onnx.helper.make_tensor_value_info, onnx.TensorProto
    inputs = [info("retina", kinds.UINT8, ["N", *contract.retina.stack_shape])]
    outputs = [
        info("q_values", kinds.FLOAT, ["N", len(contract.actions)]),
        info("action", kinds.INT64, ["N"]),
    ]
    if size := contract.state.size:
        inputs.append(info("state", kinds.FLOAT, ["N", size]))
        outputs.append(info("state_next", kinds.FLOAT, ["N", size]))
    translation.prune([output.name for output in outputs])
    graph = onnx.helper.make_graph(
        translation.nodes, "reflexarc_policy", inputs, outputs, translation.constants
    )
    model = onnx.helper.make_model(
        graph, opset_imports=[onnx.helper.make_opsetid("", OPSET)], producer_name="reflexarc"
    )
    model.ir_version = IR_VERSION
    return model
