"""The parity check before a policy file is written: its original, NumPy and onnxruntime must agree.

- What the file was made from, if it computes in float64 with the file's own numbers and rounds once
  (torch does), and the NumPy reference: to 1e-6 · max(1, |value|) and what float64 itself may get
  wrong with these weights, and in the action. An original in float32, or with constants that
  float32 does not have, is held to what onnxruntime is held to: no more can be known of it.
- onnxruntime in float32 and the NumPy reference: to the contract's tolerance, and in the action
  except where their values differ by rounding only; in batches of many and of one.
- With a memory, for memories of all kinds, the next ones included; and along the golden sequences,
  where k ticks may differ by k times as much.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import onnx

from reflexarc_runtime.arrays import Actions, Memories, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.agreement import Floats, flips, within_tolerance
from reflexarc_runtime.policy.golden_check import Graph, start_of
from reflexarc_runtime.policy.policy import load_policy
from reflexarc_trainer.policy.probes import Probes, golden_sequences
from reflexarc_trainer.policy.refusal_reasons import Refusing, not_finite

NUMPY_TOLERANCE = 1e-6
_DOUBLE = 2.0**-29
"""What float64 rounds by, in units of what float32 does."""
SINGLES = 32
"""Number of retinas that are also given one at a time."""

Decided: TypeAlias = tuple[QValues, Actions, Memories | None]


@dataclass(frozen=True)
class Original:
    """What a file was made from, and has to agree with."""

    name: str
    decide: Callable[[RetinaBatch, Memories | None], Decided]
    """Q-values (n, actions), actions (n,), and the next memories (n, size) if some were given."""
    is_double: bool
    """Whether it computes in float64 with the numbers of the file, as the NumPy reference does."""

    def tolerance(self, contract: PolicyContract, bound: float) -> float:
        """How near to it the NumPy reference has to come, times max(1, |value|)."""
        return NUMPY_TOLERANCE + self.rounding(contract, bound)

    def rounding(self, contract: PolicyContract, bound: float) -> float:
        """Up to which difference of values another winner is rounding."""
        in_double = _DOUBLE * bound if self.is_double else bound
        return min(in_double, contract.q_tolerance)


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


def check_finite(reference: Graph, probes: Probes) -> None:
    """Check that the reference computes numbers that float32 has.

    Raises:
        PolicyError: it does not.
    """
    q_values, _, following = reference.run(probes.retinas, probes.memories)
    if not np.isfinite(q_values).all():
        raise PolicyError(f"export: {not_finite(q_values)}; nothing was written")
    if following is not None and not np.isfinite(following).all():
        raise PolicyError(f"export: the memory: {not_finite(following)}; nothing was written")


def check_parity(original: Original, model: bytes, probes: Probes, bound: float) -> None:
    """Check that an ONNX file computes what it was made from.

    Args:
        original: with the weights of the file.
        model: content of the ONNX file, contract and golden vectors included.
        probes: what to check it with.
        bound: of what float32 gets wrong (`rounding_bound.py`); infinite if none is known.

    Raises:
        PolicyError: two of the original, NumPy and onnxruntime differ.
    """
    contract = load_policy(model, "numpy", bounds=None).contract
    refusing = Refusing(bound)
    got = _decided(model, "numpy", probes, len(probes.retinas))
    expected = original.decide(probes.retinas, probes.memories)
    allowed, rounding = original.tolerance(contract, bound), original.rounding(contract, bound)
    _require(f"NumPy and {original.name}", got, expected, allowed, rounding, refusing.translated)
    few = Probes(probes.retinas[:SINGLES], _first(probes.memories, SINGLES))
    singles, together = (_decided(model, "numpy", few, batch) for batch in (1, SINGLES))
    who = "NumPy with one retina at a time and with many"
    in_batches = NUMPY_TOLERANCE + _DOUBLE * min(bound, 1.0)
    _require(who, singles, together, in_batches, _DOUBLE * min(bound, 1.0), refusing.rounded)
    for some, batch in ((probes, len(probes.retinas)), (few, 1)):
        got = _decided(model, "onnxruntime", some, batch)
        expected = _decided(model, "numpy", some, len(some.retinas))
        who = f"onnxruntime (batch {batch}) and NumPy"
        _require(who, got, expected, contract.q_tolerance, contract.q_tolerance, refusing.rounded)
    for sequence in golden_sequences(contract):
        _check_sequence(original, model, contract, sequence, bound)
    load_policy(model, "onnxruntime", bounds=None)  # as a robot will, golden vectors and all


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
    original: Original,
    model: bytes,
    contract: PolicyContract,
    sequence: RetinaBatch,
    bound: float,
) -> None:
    """Each goes its own way, tick by tick, from its own memory."""
    graphs = [
        load_policy(model, name, verify=False, bounds=None).graph
        for name in ("numpy", "onnxruntime")
    ]
    own, rounding = original.tolerance(contract, bound), original.rounding(contract, bound)
    refusing, start = Refusing(bound), start_of(contract, 1)
    reference, fast, slow = start, start, start
    for tick, retina in enumerate(sequence[:, np.newaxis], start=1):
        expected = graphs[0].run(retina, reference)
        by_runtime, by_original = graphs[1].run(retina, fast), original.decide(retina, slow)
        where = f"{tick} ticks into a sequence"
        who, why = f"NumPy and {original.name}, {where},", refusing.grown
        _require(who, expected, by_original, tick * own, tick * rounding, why)
        allowed, who = tick * contract.q_tolerance, f"onnxruntime and NumPy, {where},"
        _require(who, by_runtime, expected, allowed, allowed, why)
        reference, fast, slow = expected[2], by_runtime[2], by_original[2]


def _first(memories: Memories | None, count: int, start: int = 0) -> Memories | None:
    return None if memories is None else memories[start : start + count]


def _require(
    who: str,
    got: Decided,
    expected: Decided,
    tolerance: float,
    rounding: float,
    why: Callable[[float, QValues], str],
) -> None:
    """Refuse what differs by more than the tolerance; in the winners, by more than rounding."""
    agree = within_tolerance(got[0], expected[0], tolerance)
    agree = agree and not flips(got[1], expected[1], expected[0], rounding).any()
    apart = _largest(got[0], expected[0])
    if got[2] is not None and expected[2] is not None:
        agree = agree and within_tolerance(got[2], expected[2], tolerance)
        apart = max(apart, _largest(got[2], expected[2]))
    if not agree:
        raise PolicyError(
            f"export: {who} do not agree (largest difference {apart:.3g} of max(1, |value|), "
            f"allowed {tolerance:.3g}): {why(apart, expected[0])}; nothing was written"
        )


def _largest(got: Floats, expected: Floats) -> float:
    exact = expected.astype(np.float64)
    with np.errstate(invalid="ignore"):  # what is not finite is a verdict, not a warning
        return float(np.max(np.abs(got - exact) / np.maximum(1.0, np.abs(exact))))
