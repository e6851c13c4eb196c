"""Export of a torch module of known operators as a policy file: one self-describing ONNX file.

The graph holds everything between a retina's bytes and the greedy action:

    retina uint8 [N, frames, eyes, rays, channels] → float → ÷ 255 → the module → q_values → argmax

and, for a policy with a memory, leads it through the module:

    state float32 [N, size] → the module → state_next

The file's metadata hold the contract with golden vectors, golden sequences for a policy with a
memory, and the tolerance between backends that its weights need (`rounding_bound.py`). Nothing is
written unless the ONNX checker accepts the file, and torch, the NumPy reference and onnxruntime
agree on it. The file's weights are float32; torch computes in float64 with the same values. The
same module and contract give the same bytes, for no date goes into them.
"""

import copy
import dataclasses
from pathlib import Path

import numpy as np
import onnx
from torch import nn

from reflexarc_runtime.arrays import RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.files import write_atomically
from reflexarc_runtime.policy.model_file import with_contract
from reflexarc_runtime.policy.numpy_backend import NumpyGraph
from reflexarc_runtime.sensing.ray_values import FULL_SCALE
from reflexarc_trainer.policy.golden_vectors import golden_of
from reflexarc_trainer.policy.parity import check_model, check_module, check_parity
from reflexarc_trainer.policy.probes import (
    Probes,
    probe_memories,
    probe_retinas,
    reached_memories,
)
from reflexarc_trainer.policy.rounding.rounding_bound import tolerance_for
from reflexarc_trainer.policy.translation.graph_builder import Translation
from reflexarc_trainer.policy.translation.onnx_graph import translate

OPSET = 17
IR_VERSION = 8
"""With opset 17 it is what runtimes since 2022 read."""


def export(
    module: nn.Module,
    contract: PolicyContract,
    path: Path,
    *,
    recorded: RetinaBatch | None = None,
) -> PolicyContract:
    """Write a module as a policy file.

    Args:
        module: maps floats in [0, 1] (n, frames, eyes, rays, channels) to Q-values (n, actions).
            With a memory, it maps these and states (n, size) to Q-values and the next states.
        contract: what the policy sees and does. Its golden vectors are replaced; its tolerance
            is raised where the weights need more.
        path: the file.
        recorded: retinas of a drive, to check beside random ones: uint8 (n, frames, eyes, rays,
            channels).

    Returns:
        The contract as written, golden vectors included.

    Raises:
        PolicyError: the module has an operator that cannot be exported, its shapes are not those
            of the contract, or the backends do not agree. The file is then unchanged.
    """
    module = as_exported(module)
    retinas = probe_retinas(contract, recorded)
    check_module(module, contract, retinas)
    graph = build_model(module, contract)
    model = graph.SerializeToString(deterministic=True)
    check_model(model)
    contract, probes = _proven(graph, contract, retinas)
    model = with_contract(model, contract)
    check_parity(module, model, probes)
    write_atomically(path, model)
    return contract


def as_exported(module: nn.Module) -> nn.Module:
    """A copy in float64, with the weights rounded to the float32 values that the file will hold."""
    return copy.deepcopy(module).float().double().eval()


def build_model(module: nn.Module, contract: PolicyContract) -> onnx.ModelProto:
    """The ONNX model of a module that `as_exported` made, without a contract."""
    translation = Translation()
    full_scale = translation.constant("full_scale", np.array(FULL_SCALE, np.float32))
    pixels = translation.node("Cast", ["retina"], to=onnx.TensorProto.FLOAT)
    inputs = {translation.node("Div", [pixels, full_scale]): contract.retina.stack_shape}
    memory: dict[str, tuple[int, ...]] = {}
    if contract.state.size:
        memory["state"] = (contract.state.size,)
    q_values, *following = translate(module, {**inputs, **memory}, translation)
    translation.node("Identity", [q_values], "q_values")
    translation.node("ArgMax", ["q_values"], "action", axis=1, keepdims=0, select_last_index=0)
    for name in following:
        translation.node("Identity", [name], "state_next")
    return _model(translation, contract)


def _proven(
    model: onnx.ModelProto, contract: PolicyContract, retinas: RetinaBatch
) -> tuple[PolicyContract, Probes]:
    """The contract with what proves the policy, and the inputs to check it with."""
    reference = NumpyGraph(model)
    reached = reached_memories(reference, contract) if contract.state.size else None
    memories = None if reached is None else probe_memories(contract, reached, len(retinas))
    probes = Probes(retinas, memories)
    contract = dataclasses.replace(
        contract,
        q_tolerance=tolerance_for(model, probes, contract.q_tolerance),
        golden=golden_of(reference, contract, retinas),
    )
    return contract, probes


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
