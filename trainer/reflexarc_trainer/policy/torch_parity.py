"""Torch as the original of a policy file: what a module decides, and whether it fits a contract."""

import numpy as np
import torch
from torch import nn

from reflexarc_runtime.arrays import Memories, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.golden_check import start_of
from reflexarc_runtime.sensing.ray_values import FULL_SCALE
from reflexarc_trainer.policy.parity import Decided


def check_module(module: nn.Module, contract: PolicyContract, retinas: RetinaBatch) -> None:
    """Check that a module takes the contract's retinas and has one output per action.

    Raises:
        PolicyError: it fails on the retinas, or its outputs have other shapes.
    """
    wanted = (len(retinas), len(contract.actions))
    q_values, following = _tried(module, contract, retinas)
    if q_values.shape != wanted:
        raise PolicyError(
            f"export: expected Q-values {wanted} of the module, got {tuple(q_values.shape)}"
        )
    memory = (len(retinas), contract.state.size)
    if contract.state.size and following.shape != memory:
        raise PolicyError(
            f"export: expected next states {memory} of the module, got {tuple(following.shape)}; "
            "the contract's state.size and the module do not fit"
        )


def torch_decide(
    module: nn.Module, retinas: RetinaBatch, memories: Memories | None = None
) -> Decided:
    """What torch computes in float64, rounded once to float32, and greedy actions.

    Returns:
        Q-values (n, actions), actions (n,), and the next memories (n, size) if some were given.
    """
    pixels = torch.from_numpy(retinas).double() / FULL_SCALE
    with torch.no_grad():
        if memories is None:
            q_values, following = module(pixels), None
        else:
            q_values, following = module(pixels, torch.from_numpy(memories).double())
    with np.errstate(over="ignore"):  # what is not finite is a verdict, not a warning
        rounded: QValues = q_values.numpy().astype(np.float32)
        next_memories = None if following is None else following.numpy().astype(np.float32)
    return rounded, np.argmax(rounded, axis=-1), next_memories


def _tried(
    module: nn.Module, contract: PolicyContract, retinas: RetinaBatch
) -> tuple[torch.Tensor, torch.Tensor]:
    """Q-values of the module, and the next memories; without a memory, empty ones."""
    memories = start_of(contract, len(retinas))
    inputs = [torch.from_numpy(retinas).double() / FULL_SCALE]
    if memories is not None:
        inputs.append(torch.from_numpy(memories).double())
    try:
        with torch.no_grad():
            result = module(*inputs)
    except (RuntimeError, ValueError, TypeError, IndexError) as error:
        reason = " ".join(str(error).split())[:200]
        raise PolicyError(
            f"export: the module fails on retinas {retinas.shape}: {reason}"
        ) from None
    results = result if isinstance(result, tuple) else (result,)
    if len(results) != len(inputs):
        wanted = "Q-values" if memories is None else "Q-values and next states"
        raise PolicyError(
            f"export: expected {wanted} of the module (the contract's state.size is "
            f"{contract.state.size}), got {len(results)} tensors"
        )
    return results[0], torch.empty(0) if memories is None else results[1]
