"""Export of a torch module of known operators as a policy file: one self-describing ONNX file.

The module's nodes stand between the retina's bytes, as floats ÷ 255, and the Q-values; what else is
in the file, and what is checked before it is written, says `graph_export.py`. The file's weights
are float32; torch computes in float64 with the same values.
"""

import copy
from pathlib import Path

import numpy as np
import onnx
import torch
from torch import nn

from reflexarc_runtime.arrays import RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.sensing.ray_values import FULL_SCALE
from reflexarc_trainer.policy.graph_export import export_graph, finished
from reflexarc_trainer.policy.parity import Original
from reflexarc_trainer.policy.probes import probe_retinas
from reflexarc_trainer.policy.torch_parity import check_module, torch_decide
from reflexarc_trainer.policy.translation.graph_builder import Translation
from reflexarc_trainer.policy.translation.onnx_graph import translate
from reflexarc_trainer.policy.translation.tracing import without_casts


def export(
    module: nn.Module,
    contract: PolicyContract,
    path: Path | str,
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
    translation = Translation()
    model = build_model(module, contract, translation)
    original = Original(
        "torch", lambda *inputs: torch_decide(module, *inputs), is_double=translation.is_exact
    )
    return export_graph(model, original, contract, Path(path), retinas)


def as_exported(module: nn.Module) -> nn.Module:
    """A copy in float64, with the weights rounded to the float32 values that the file will hold."""
    module = copy.deepcopy(module).float()
    for part in module.modules():
        if isinstance(part, nn.RMSNorm) and part.eps is None:
            part.eps = torch.finfo(torch.float32).eps  # which else follows the precision
    return without_casts(module.double().eval())


def build_model(
    module: nn.Module, contract: PolicyContract, translation: Translation | None = None
) -> onnx.ModelProto:
    """The ONNX model of a module that `as_exported` made, without a contract.

    Args:
        module: the module.
        contract: what it sees and does.
        translation: an empty graph to fill, for who wants to know how it went.
    """
    translation = Translation() if translation is None else translation
    full_scale = translation.constant("full_scale", np.array(FULL_SCALE, np.float32))
    pixels = translation.node("Cast", ["retina"], to=onnx.TensorProto.FLOAT)
    inputs = {translation.node("Div", [pixels, full_scale]): contract.retina.stack_shape}
    memory: dict[str, tuple[int, ...]] = {}
    if contract.state.size:
        memory["state"] = (contract.state.size,)
    q_values, *following = translate(module, {**inputs, **memory}, translation)
    return finished(translation, q_values, next(iter(following), None), contract)
