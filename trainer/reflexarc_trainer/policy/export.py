"""Export of a torch module of known operators as a policy file: one self-describing ONNX file.

The graph holds everything between a retina's bytes and the greedy action:

    retina uint8 [N, frames, eyes, rays, channels] → float → ÷ 255 → the module → q_values → argmax

and the file's metadata hold the contract with golden vectors. Nothing is written unless the ONNX
checker accepts the file, and torch, the NumPy reference and onnxruntime agree on it. The file's
weights are float32; torch computes in float64 with the same values. The same module and contract
give the same bytes, for no date goes into them.
"""

import copy
import dataclasses
from pathlib import Path

import numpy as np
import onnx
from torch import nn

from reflexarc_runtime.arrays import RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.golden import GoldenVectors
from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.files import write_atomically
from reflexarc_runtime.policy.model_file import with_contract
from reflexarc_runtime.policy.policy import load_policy
from reflexarc_runtime.sensing.retina import FULL_SCALE
from reflexarc_trainer.policy.onnx_graph import Translation, translate
from reflexarc_trainer.policy.parity import check_model, check_module, check_parity

OPSET = 17
IR_VERSION = 8
"""With opset 17 it is what runtimes since 2022 read."""
GOLDEN_VECTORS = 16
PARITY_RETINAS = 512


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
        contract: what the policy sees and does; its golden vectors are replaced.
        path: the file.
        recorded: retinas of a drive, to check beside random ones: uint8 (n, frames, eyes, rays,
            channels).

    Returns:
        The contract as written, golden vectors included.

    Raises:
        PolicyError: the module has an operator that cannot be exported, its shapes are not those
            of the contract, or the backends do not agree. The file is then unchanged.
    """
    module = _as_exported(module)
    retinas = _probe_retinas(contract, recorded)
    check_module(module, contract, retinas)
    model = _build(module, contract).SerializeToString(deterministic=True)
    check_model(model)
    model = with_contract(model, contract)
    contract = dataclasses.replace(contract, golden=_golden(model, retinas))
    model = with_contract(model, contract)
    check_parity(module, model, retinas)
    write_atomically(path, model)
    return contract


def _as_exported(module: nn.Module) -> nn.Module:
    """A copy in float64, with the weights rounded to the float32 values that the file will hold."""
    return copy.deepcopy(module).float().double().eval()


def _build(module: nn.Module, contract: PolicyContract) -> onnx.ModelProto:
    translation = Translation()
    full_scale = translation.constant("full_scale", np.array(FULL_SCALE, np.float32))
    pixels = translation.node("Cast", ["retina"], to=onnx.TensorProto.FLOAT)
    inputs = translation.node("Div", [pixels, full_scale])
    output = translate(module, inputs, translation)
    translation.node("Identity", [output], "q_values")
    translation.node("ArgMax", ["q_values"], "action", axis=1, keepdims=0, select_last_index=0)
    return _model(translation, contract)


def _model(translation: Translation, contract: PolicyContract) -> onnx.ModelProto:
    info = onnx.helper.make_tensor_value_info
    actions = len(contract.actions)
    graph = onnx.helper.make_graph(
        translation.nodes,
        "reflexarc_policy",
        [info("retina", onnx.TensorProto.UINT8, ["N", *contract.retina.stack_shape])],
        [
            info("q_values", onnx.TensorProto.FLOAT, ["N", actions]),
            info("action", onnx.TensorProto.INT64, ["N"]),
        ],
        translation.constants,
    )
    model = onnx.helper.make_model(
        graph, opset_imports=[onnx.helper.make_opsetid("", OPSET)], producer_name="reflexarc"
    )
    model.ir_version = IR_VERSION
    return model


def _probe_retinas(contract: PolicyContract, recorded: RetinaBatch | None) -> RetinaBatch:
    """The retinas of the check: recorded ones, the darkest, the brightest, random ones."""
    shape = contract.retina.stack_shape
    generator = np.random.default_rng(0)
    noise = generator.integers(0, 256, (PARITY_RETINAS, *shape), np.uint8)
    sparse = noise * (generator.random(noise.shape) < 0.3)
    ends = np.stack([np.zeros(shape, np.uint8), np.full(shape, FULL_SCALE, np.uint8)])
    seen = np.empty((0, *shape), np.uint8) if recorded is None else recorded[:PARITY_RETINAS]
    if seen.shape[1:] != shape:
        raise PolicyError(f"recorded retinas: expected (n, {shape}), got {seen.shape}")
    return np.concatenate([seen, ends, noise, sparse.astype(np.uint8)])


def _golden(model: bytes, retinas: RetinaBatch) -> GoldenVectors:
    """Evenly picked retinas, with what the NumPy reference computes for them."""
    chosen = retinas[np.linspace(0, len(retinas) - 1, GOLDEN_VECTORS).astype(int)]
    q_values, actions = load_policy(model, "numpy", verify=False).decide(chosen)
    return GoldenVectors(
        retinas=tuple(tuple(map(int, row)) for row in chosen.reshape(len(chosen), -1)),
        q_values=tuple(tuple(map(float, row)) for row in q_values),
        actions=tuple(map(int, actions)),
    )
