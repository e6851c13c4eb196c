"""The parity check before a policy file is written: torch, NumPy and onnxruntime must agree.

- torch in float64, rounded once, and the NumPy reference: |ΔQ| ≤ 1e-6 and equal actions.
- onnxruntime in float32 and the NumPy reference: |ΔQ| ≤ 1e-6 · max(1, |Q|), and equal actions
  except where their values differ by rounding only; in batches of many and of one.
"""

import numpy as np
import onnx
import torch
from torch import nn

from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.agreement import flips, within_tolerance
from reflexarc_runtime.policy.policy import load_policy
from reflexarc_runtime.sensing.retina import FULL_SCALE

NUMPY_TOLERANCE = 1e-6
SINGLES = 32
"""Number of retinas that are also given one at a time."""


def check_module(module: nn.Module, contract: PolicyContract, retinas: RetinaBatch) -> None:
    """Check that a module takes the contract's retinas and has one output per action.

    Raises:
        PolicyError: it fails on the retinas, or its output has another shape.
    """
    wanted = (len(retinas), len(contract.actions))
    try:
        got = torch_decide(module, retinas)[0].shape
    except (RuntimeError, ValueError, TypeError, IndexError) as error:
        reason = " ".join(str(error).split())[:200]
        raise PolicyError(
            f"export: the module fails on retinas {retinas.shape}: {reason}"
        ) from None
    if got != wanted:
        raise PolicyError(f"export: expected Q-values {wanted} of the module, got {got}")


def check_model(model: bytes) -> None:
    """Check an ONNX file with the ONNX checker, shapes included.

    Raises:
        PolicyError: the checker refuses the file.
    """
    try:
        onnx.checker.check_model(onnx.load_from_string(model), full_check=True)
    except (onnx.checker.ValidationError, onnx.shape_inference.InferenceError) as error:
        reason = " ".join(str(error).split())[:200]
        raise PolicyError(f"export: the ONNX checker refuses the graph: {reason}") from None


def check_parity(module: nn.Module, model: bytes, retinas: RetinaBatch) -> None:
    """Check that an ONNX file computes what the module computes.

    Args:
        module: in float64, with the weights of the file.
        model: content of the ONNX file, contract and golden vectors included.
        retinas: uint8 (n, frames, eyes, rays, channels).

    Raises:
        PolicyError: two of torch, NumPy and onnxruntime differ.
    """
    expected, winners = torch_decide(module, retinas)
    q_values, actions = load_policy(model, "numpy").decide(retinas)
    apart = np.abs(q_values.astype(np.float64) - expected)
    agree = bool(np.all(apart <= NUMPY_TOLERANCE)) and np.array_equal(actions, winners)
    _require(agree, "NumPy and torch", q_values, expected)
    _check_onnxruntime(model, retinas, len(retinas))
    _check_onnxruntime(model, retinas[:SINGLES], 1)


def torch_decide(module: nn.Module, retinas: RetinaBatch) -> tuple[QValues, Actions]:
    """Q-values that torch computes in float64, rounded once to float32, and greedy actions."""
    with torch.no_grad():
        q_values = module(torch.from_numpy(retinas).double() / FULL_SCALE)
    rounded: QValues = q_values.numpy().astype(np.float32)
    return rounded, np.argmax(rounded, axis=-1)


def _check_onnxruntime(model: bytes, retinas: RetinaBatch, batch: int) -> None:
    expected, winners = load_policy(model, "numpy").decide(retinas)
    policy = load_policy(model, "onnxruntime")
    pieces = [policy.decide(retinas[i : i + batch]) for i in range(0, len(retinas), batch)]
    q_values = np.concatenate([q for q, _ in pieces])
    actions = np.concatenate([a for _, a in pieces])
    agree = within_tolerance(q_values, expected) and not flips(actions, winners, expected).any()
    _require(agree, f"onnxruntime (batch {batch}) and NumPy", q_values, expected)


def _require(agree: bool, who: str, got: QValues, expected: QValues) -> None:
    if not agree:
        apart = float(np.max(np.abs(got.astype(np.float64) - expected)))
        raise PolicyError(
            f"export: {who} do not agree (largest difference {apart:.3g}); nothing was written"
        )
