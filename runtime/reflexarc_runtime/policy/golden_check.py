"""Proof at load that a policy computes what it computed when it was exported."""

from typing import Protocol

import numpy as np

from reflexarc_runtime.arrays import Actions, Memories, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.golden import GoldenSequence
from reflexarc_runtime.errors import PolicyError, first_line
from reflexarc_runtime.policy.agreement import Floats, flips, within_tolerance

_LIKE_ROUNDING = 1e-3
"""A difference that float32 may make with large weights, times the larger of 1 and |Q|."""


class Graph(Protocol):
    """The graph of a policy, ready to be computed by one of the backends."""

    name: str

    def run(
        self, retinas: RetinaBatch, memories: Memories | None
    ) -> tuple[QValues, Actions, Memories | None]:
        """Q-values (n, actions), winners (n,) and the next memories (n, size), if it has one."""
        ...

    def end_run(self) -> None:
        """Make the run that is going on, if any, raise `DecisionEndedError`; from any thread."""
        ...


def reproduce_golden_vectors(graph: Graph, contract: PolicyContract) -> None:
    """Compute the golden vectors and sequences of a contract again.

    Raises:
        PolicyError: there are none, the graph fails, or the values are not those of the contract.
    """
    golden = contract.golden
    if not golden.retinas:
        raise PolicyError("the contract has no golden vectors; export the policy again")
    if contract.state.size and not golden.sequences:
        raise PolicyError("the contract has no golden sequences; export the policy again")
    stacks = _stacks(golden.retinas, contract)
    got = run_or_refuse(graph, contract, stacks, start_of(contract, len(stacks)))
    expected = np.array(golden.q_values, np.float32), np.array(golden.actions)
    _require_equal("vectors", graph, contract.q_tolerance, got, (*expected, None))
    for sequence in golden.sequences:
        _reproduce_sequence(graph, contract, sequence)


def start_of(contract: PolicyContract, count: int) -> Memories | None:
    """The memories of `count` policies that have not begun: (count, size); None without memory."""
    if not contract.state.size:
        return None
    return np.tile(np.array(contract.state.start_value, np.float32), (count, 1))


def _reproduce_sequence(graph: Graph, contract: PolicyContract, golden: GoldenSequence) -> None:
    memories = start_of(contract, 1)
    q_values, actions = [], []
    for stack in _stacks(golden.retinas, contract):
        q, action, memories = run_or_refuse(graph, contract, stack[np.newaxis], memories)
        q_values.append(q[0])
        actions.append(action[0])
    got = np.array(q_values), np.array(actions), memories
    end = np.array([golden.end], np.float32)
    expected = np.array(golden.q_values, np.float32), np.array(golden.actions), end
    # Each tick adds its own rounding to what the memory brings from those before it.
    allowed = contract.q_tolerance * len(golden.retinas)
    _require_equal("sequences", graph, allowed, got, expected)


def _stacks(retinas: tuple[tuple[int, ...], ...], contract: PolicyContract) -> RetinaBatch:
    return np.array(retinas, np.uint8).reshape(len(retinas), *contract.retina.stack_shape)


def run_or_refuse(
    graph: Graph, contract: PolicyContract, retinas: RetinaBatch, memories: Memories | None
) -> tuple[QValues, Actions, Memories | None]:
    """Compute a batch, and check the shapes of what comes.

    Raises:
        PolicyError: the graph fails, or gives other shapes than those of its contract.
    """
    try:
        q_values, actions, following = graph.run(retinas, memories)
    except Exception as error:  # a graph from outside can fail in any operator
        raise PolicyError(f"the graph does not run on {graph.name}: {first_line(error)}") from None
    wanted = (len(retinas), len(contract.actions))
    if q_values.shape != wanted or actions.shape != wanted[:1]:
        raise PolicyError(
            f"expected q_values {wanted}, action {wanted[:1]}; got "
            f"{q_values.shape} and {actions.shape}"
        )
    if following is not None and following.shape != (len(retinas), contract.state.size):
        raise PolicyError(
            f"expected state_next {(len(retinas), contract.state.size)}, got {following.shape}"
        )
    return q_values, actions, following


def _require_equal(
    what: str,
    graph: Graph,
    allowed: float,
    got: tuple[QValues, Actions, Memories | None],
    expected: tuple[QValues, Actions, Memories | None],
) -> None:
    q_values, actions, end = expected
    tolerance = 0.0 if graph.name == "numpy" else allowed
    agree = _same(got[0], q_values, tolerance) and _same_winners(
        got[1], actions, q_values, tolerance
    )
    if end is not None and got[2] is not None:
        agree = agree and _same(got[2], end, tolerance)
    if not agree:
        apart = _apart(got[0], q_values)
        if end is not None and got[2] is not None:
            apart = max(apart, _apart(got[2], end))
        raise PolicyError(
            f"golden {what} are not reproduced on {graph.name}: {_reason(apart, tolerance)}"
        )


def _apart(got: Floats, expected: Floats) -> float:
    """The largest difference, times the larger of 1 and the expected value."""
    exact = expected.astype(np.float64)
    with np.errstate(invalid="ignore"):
        return float(np.max(np.abs(got - exact) / np.maximum(1.0, np.abs(exact))))


def _reason(apart: float, tolerance: float) -> str:
    """What a difference says: rounding is small, other weights are not."""
    if not tolerance < apart <= _LIKE_ROUNDING:  # so what is not a number counts as large
        return "the weights are not those that were exported; copy or export the file again"
    if not tolerance:
        return (
            f"they differ by {apart:.3g} of max(1, |Q|), where the bits must be equal: they were "
            "made by something else than this backend, or the file is damaged; export it again"
        )
    return (
        f"they differ by {apart:.3g} of max(1, |Q|), more than the q_tolerance of its contract "
        f"allows, {tolerance:.3g}: that is too small for its weights, or the file is damaged; "
        "export it again (reflexarc.export finds the tolerance)"
    )


def _same(got: Floats, expected: Floats, tolerance: float) -> bool:
    """Equal in bits if there is no tolerance."""
    if not tolerance:
        return got.tobytes() == expected.tobytes()
    return within_tolerance(got, expected, tolerance)


def _same_winners(got: Actions, expected: Actions, q_values: QValues, tolerance: float) -> bool:
    if not tolerance:
        return bool(np.array_equal(got, expected))
    return not flips(got, expected, q_values, tolerance).any()
