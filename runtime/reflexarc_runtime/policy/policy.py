"""A policy: from retinas to action values and the winning action.

`Policy` is a protocol: trained policies, hand-written baselines and shadows all fit it.
`load_policy` makes one from the single file that the trainer exported. It checks the contract that
the file carries, and reproduces the golden vectors on the backend that it will use, or refuses.

A policy may have a memory: values that it is given with a retina, and gives back for the next one.
"""

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Protocol, overload

import onnx

from reflexarc_runtime.arrays import Actions, Memories, QValues, RetinaBatch
from reflexarc_runtime.contract.bounds import Bounds, check_bounds
from reflexarc_runtime.contract.contract import PolicyContract, why_unsealed
from reflexarc_runtime.contract.text import digest_in
from reflexarc_runtime.errors import PolicyError, ReflexarcError, first_line
from reflexarc_runtime.policy.golden_check import Graph, reproduce_golden_vectors, start_of
from reflexarc_runtime.policy.model_file import (
    check_names,
    contract_text,
    parse_model,
    policy_hash,
    read_model,
)
from reflexarc_runtime.policy.numpy_backend import NumpyGraph

USUAL_BOUNDS = Bounds()


class Backend(StrEnum):
    """What computes the graph."""

    NUMPY = "numpy"
    """The reference: the same bits everywhere."""
    ONNXRUNTIME = "onnxruntime"
    """Any operator; equal in the action and to the contract's `q_tolerance`."""


class Policy(Protocol):
    """Anything that turns retinas into action values and winners."""

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        """Decide for a batch.

        Args:
            retinas: uint8 (n, frames, eyes, rays, channels).

        Returns:
            Q-values float32 (n, actions) and the index of the winning action int64 (n,).
        """
        ...


class RememberingPolicy(Protocol):
    """A policy with a memory, which whoever calls it keeps for it."""

    def decide(self, retinas: RetinaBatch, memories: Memories) -> tuple[QValues, Actions, Memories]:
        """Decide for a batch.

        Args:
            retinas: uint8 (n, frames, eyes, rays, channels).
            memories: what each remembers, float32 (n, size).

        Returns:
            Q-values float32 (n, actions), the index of the winning action int64 (n,), and what
            each remembers when the next input comes, float32 (n, size).
        """
        ...


@dataclass(frozen=True)
class LoadedPolicy:
    """A policy from a file, checked against the contract that the file carries."""

    contract: PolicyContract
    policy_hash: str
    """SHA-256 of the file."""
    data: bytes
    """The file itself, to be attached to logs and sent to bodies that ask for it."""
    graph: Graph
    notes: tuple[str, ...] = ()
    """What its user should know."""
    digest: str = ""
    """SHA-256 that seals the contract's text; empty if it was written without one."""

    @property
    def backend(self) -> Backend:
        """What computes it."""
        return Backend(self.graph.name)

    @overload
    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]: ...

    @overload
    def decide(
        self, retinas: RetinaBatch, memories: Memories
    ) -> tuple[QValues, Actions, Memories]: ...

    def decide(
        self, retinas: RetinaBatch, memories: Memories | None = None
    ) -> tuple[QValues, Actions] | tuple[QValues, Actions, Memories]:
        """Decide for a batch: see `Policy.decide` and `RememberingPolicy.decide`.

        Without memories given, a policy that has one decides from its start value.
        """
        if memories is None:
            return self.graph.run(retinas, start_of(self.contract, len(retinas)))[:2]
        q_values, actions, following = self.graph.run(retinas, memories)
        return q_values, actions, memories if following is None else following

    def end_decision(self) -> None:
        """Make the decision that is going on raise `DecisionEndedError`, if its backend can."""
        self.graph.end_run()


def load_policy(
    source: Path | str | bytes,
    backend: Backend | str = Backend.NUMPY,
    *,
    verify: bool = True,
    bounds: Bounds | None = USUAL_BOUNDS,
    name: str = "policy",
) -> LoadedPolicy:
    """Load a policy and prove that it is the one that was exported.

    Args:
        source: path of the ONNX file, or its bytes.
        backend: what shall compute it.
        verify: reproduce the golden vectors; only the exporter, which makes them, does not.
        bounds: what it may ask for at most; None where nothing will move by it, as in a replay.
        name: what errors call bytes; a file is called by its path.

    Raises:
        PolicyError: the file is missing or is not ONNX, or does not reproduce its golden vectors.
        ContractError: the contract in it is missing, malformed, newer than this package, or asks
            for more than the bounds allow.
    """
    where, data = _read(source, name)
    try:
        return _load(data, Backend(backend), verify, bounds)
    except ReflexarcError as error:
        raise type(error)(f"{where}: {error}") from None


def load_contract(
    source: Path | str | bytes, *, bounds: Bounds | None = USUAL_BOUNDS, name: str = "policy"
) -> PolicyContract:
    """Read what a policy wants to see and may ask for; nothing of its graph is built or computed.

    So a policy that hangs, or that this backend does not know, is none of a body's business.

    Args:
        source: path of the ONNX file, or its bytes.
        bounds: what it may ask for at most; None where nothing will move by it.
        name: what errors call bytes.

    Raises:
        PolicyError: the file is missing, too large, is not ONNX, or does not fit its contract.
        ContractError: see `load_policy`.
    """
    where, data = _read(source, name)
    try:
        return _contract_of(parse_model(data), bounds)
    except ReflexarcError as error:
        raise type(error)(f"{where}: {error}") from None


def _read(source: Path | str | bytes, name: str = "policy") -> tuple[str, bytes]:
    """What to call the file, and its bytes."""
    if isinstance(source, bytes):
        return name, source
    return str(source), read_model(Path(source))


def _load(data: bytes, backend: Backend, verify: bool, bounds: Bounds | None) -> LoadedPolicy:
    model = parse_model(data)
    contract = _contract_of(model, bounds)
    graph = _build(model, data, backend)
    if verify:
        reproduce_golden_vectors(graph, contract)
    text = contract_text(model)
    notes = tuple(filter(None, [why_unsealed(text)]))
    return LoadedPolicy(contract, policy_hash(data), data, graph, notes, digest_in(text))


def _contract_of(model: onnx.ModelProto, bounds: Bounds | None) -> PolicyContract:
    contract = PolicyContract.from_json(contract_text(model))
    _check_reserved(contract)
    if bounds is not None:
        check_bounds(contract, bounds)
    check_names(model, contract)
    return contract


def _check_reserved(contract: PolicyContract) -> None:
    if contract.goal:
        raise PolicyError(
            "it wants a goal, which this version of reflexarc has no way to give; upgrade "
            "reflexarc, or export a policy without one"
        )


def _build(model: onnx.ModelProto, data: bytes, backend: Backend) -> Graph:
    try:
        return NumpyGraph(model) if backend is Backend.NUMPY else _on_onnxruntime(data)
    except PolicyError:
        raise
    except Exception as error:  # a damaged file can break any part of it
        raise PolicyError(
            f"the graph is damaged ({type(error).__name__}: {first_line(error)}); export it again"
        ) from None


def _on_onnxruntime(data: bytes) -> Graph:
    from reflexarc_runtime.policy.onnxruntime_backend import OnnxruntimeGraph

    return OnnxruntimeGraph(data)
