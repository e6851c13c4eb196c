"""The parity check before a policy file is written: torch, NumPy and onnxruntime must agree.

- torch in float64, rounded once, and the NumPy reference: to 1e-6 · max(1, |value|), and in the
  action.
- onnxruntime in float32 and the NumPy reference: to the contract's tolerance, and in the action
  except where their values differ by rounding only; in batches of many and of one.
- With a memory, for memories of all kinds, the next ones included; and along the golden sequences,
  where k ticks may differ by k times as much.
"""

from typing import TypeAlias

import numpy as np
import onnx
import torch
from torch import nn

from reflexarc_runtime.arrays import Actions, Memories, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.agreement import Floats, flips, within_tolerance
from reflexarc_runtime.policy.golden_check import start_of
from reflexarc_runtime.policy.policy import load_policy
from reflexarc_runtime.sensing.ray_values import FULL_SCALE
from reflexarc_trainer.policy.probes import Probes, golden_sequences
from reflexarc_trainer.policy.rounding.rounding_bound import LARGEST_TOLERANCE

NUMPY_TOLERANCE = 1e-6
SINGLES = 32
"""Number of retinas that are also given one at a time."""
_AMPLIFIES = "the memory makes rounding grow from tick to tick: learn smaller weights; "

Decided: TypeAlias = tuple[QValues, Actions, Memories | None]


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


def check_parity(module: nn.Module, model: bytes, probes: Probes) -> None:
    """Check that an ONNX file computes what the module computes.

    Args:
        module: in float64, with the weights of the file.
        model: content of the ONNX file, contract and golden vectors included.
        probes: what to check it with.

    Raises:
        PolicyError: two of torch, NumPy and onnxruntime differ.
    """
    contract = load_policy(model, "numpy", bounds=None).contract
    got = _decided(model, "numpy", probes, len(probes.retinas))
    expected = torch_decide(module, probes.retinas, probes.memories)
    _require("NumPy and torch", got, expected, NUMPY_TOLERANCE)
    few = Probes(probes.retinas[:SINGLES], _first(probes.memories, SINGLES))
    singles, together = (_decided(model, "numpy", few, batch) for batch in (1, SINGLES))
    _require("NumPy with one retina at a time and with many", singles, together, NUMPY_TOLERANCE)
    for some, batch in ((probes, len(probes.retinas)), (few, 1)):
        got = _decided(model, "onnxruntime", some, batch)
        expected = _decided(model, "numpy", some, len(some.retinas))
        who = f"onnxruntime (batch {batch}) and NumPy"
        _require(who, got, expected, contract.q_tolerance, _why(contract))
    for sequence in golden_sequences(contract):
        _check_sequence(module, model, contract, sequence)
    load_policy(model, "onnxruntime", bounds=None)  # as a robot will, golden vectors and all


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


def _decided(model: bytes, backend: str, probes: Probes, batch: int) -> Decided:
    """What a backend computes, given so many at a time."""
    graph = load_policy(model, backend, verify=False, bounds=None).graph
    ends = range(0, len(probes.retinas), batch)
    pieces = [
        graph.run(probes.retinas[i : i + batch], _first(probes.memories, batch, i)) for i in ends
    ]
    q_values, actions, following = zip(*pieces, strict=True)
    memories = None if probes.memories is None else np.concatenate(following)
    return np.concatenate(q_values), np.concatenate(actions), memories


def _check_sequence(
    module: nn.Module, model: bytes, contract: PolicyContract, sequence: RetinaBatch
) -> None:
    """Each goes its own way, tick by tick, from its own memory."""
    graphs = [
        load_policy(model, name, verify=False, bounds=None).graph
        for name in ("numpy", "onnxruntime")
    ]
    start = start_of(contract, 1)
    reference, fast, slow = start, start, start
    for tick, retina in enumerate(sequence[:, np.newaxis], start=1):
        expected = graphs[0].run(retina, reference)
        by_runtime, by_torch = graphs[1].run(retina, fast), torch_decide(module, retina, slow)
        where = f"{tick} ticks into a sequence"
        _require(f"NumPy and torch, {where},", expected, by_torch, tick * NUMPY_TOLERANCE)
        allowed, who = tick * contract.q_tolerance, f"onnxruntime and NumPy, {where},"
        _require(who, by_runtime, expected, allowed, _AMPLIFIES)
        reference, fast, slow = expected[2], by_runtime[2], by_torch[2]


def _first(memories: Memories | None, count: int, start: int = 0) -> Memories | None:
    return None if memories is None else memories[start : start + count]


def _require(who: str, got: Decided, expected: Decided, tolerance: float, why: str = "") -> None:
    """Refuse what differs by more than the tolerance; in the winners, by more than rounding."""
    rounding = 0.0 if who.startswith("NumPy") else tolerance
    agree = within_tolerance(got[0], expected[0], tolerance)
    agree = agree and not flips(got[1], expected[1], expected[0], rounding).any()
    apart = _largest(got[0], expected[0])
    if got[2] is not None and expected[2] is not None:
        agree = agree and within_tolerance(got[2], expected[2], tolerance)
        apart = max(apart, _largest(got[2], expected[2]))
    if not agree:
        raise PolicyError(
            f"export: {who} do not agree (largest difference {apart:.3g} of max(1, |value|), "
            f"allowed {tolerance:.3g}); {why}nothing was written"
        )


def _largest(got: Floats, expected: Floats) -> float:
    exact = expected.astype(np.float64)
    return float(np.max(np.abs(got - exact) / np.maximum(1.0, np.abs(exact))))


def _why(contract: PolicyContract) -> str:
    if contract.q_tolerance < LARGEST_TOLERANCE:
        return ""
    return "the weights are so large that float32 itself is that inexact: learn smaller ones; "
