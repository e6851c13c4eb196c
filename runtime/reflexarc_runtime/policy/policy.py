"""A policy: from retinas to action values and the winning action.

`Policy` is a protocol: trained policies, hand-written baselines and shadows all fit it.
`load_policy` makes one from the single file that the trainer exported. It checks the contract that
the file carries, and reproduces the golden vectors on the backend that it will use, or refuses.
"""

import hashlib
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Protocol

import numpy as np
import onnx
from google.protobuf.message import DecodeError

from reflexarc_runtime.arrays import Actions, Mask, QValues, RetinaBatch
from reflexarc_runtime.contract import METADATA_KEY, PolicyContract
from reflexarc_runtime.errors import ContractError, PolicyError, ReflexarcError, first_line
from reflexarc_runtime.policy.numpy_backend import NumpyGraph
from reflexarc_runtime.policy.onnxruntime_backend import OnnxruntimeGraph

Q_TOLERANCE = 1e-6
"""Largest difference between onnxruntime and the reference, times the larger of 1 and |Q|."""

MAX_FILE_BYTES = 256 << 20


class Backend(StrEnum):
    """What computes the graph."""

    NUMPY = "numpy"
    """The reference: the same bits everywhere."""
    ONNXRUNTIME = "onnxruntime"
    """Any operator; equal in the action and to 1e-6."""


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


class Graph(Protocol):
    """The graph of a policy, ready to be computed by one of the backends."""

    name: str

    def run(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        """Q-values (n, actions) and winners (n,)."""
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

    @property
    def backend(self) -> Backend:
        """What computes it."""
        return Backend(self.graph.name)

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        """Decide for a batch: see `Policy.decide`."""
        return self.graph.run(retinas)


def load_policy(
    source: Path | str | bytes, backend: Backend | str = Backend.NUMPY, *, verify: bool = True
) -> LoadedPolicy:
    """Load a policy and prove that it is the one that was exported.

    Args:
        source: path of the ONNX file, or its bytes.
        backend: what shall compute it.
        verify: reproduce the golden vectors; only the exporter, which makes them, does not.

    Raises:
        PolicyError: the file is missing or is not ONNX, or does not reproduce its golden vectors.
        ContractError: the contract in it is missing, malformed, or newer than this package.
    """
    where = "policy" if isinstance(source, bytes) else str(source)
    data = source if isinstance(source, bytes) else _read(Path(source))
    try:
        return _load(data, Backend(backend), verify)
    except ReflexarcError as error:
        raise type(error)(f"{where}: {error}") from None


def with_contract(model: bytes, contract: PolicyContract) -> bytes:
    """The same ONNX model with `contract` in its metadata, in place of any that was there."""
    proto = _parse(model)
    kept = [(p.key, p.value) for p in proto.metadata_props if p.key != METADATA_KEY]
    onnx.helper.set_model_props(proto, dict([*kept, (METADATA_KEY, contract.to_json())]))
    return proto.SerializeToString(deterministic=True)


def policy_hash(data: bytes) -> str:
    """Identity of a policy file: its SHA-256, in hexadecimal."""
    return hashlib.sha256(data).hexdigest()


def within_tolerance(q_values: QValues, reference: QValues) -> bool:
    """Whether two sets of Q-values are finite and as close as those of two backends must be."""
    if not (np.isfinite(q_values).all() and np.isfinite(reference).all()):
        return False
    allowed = Q_TOLERANCE * np.maximum(1.0, np.abs(reference))
    return bool(np.all(np.abs(q_values - reference) <= allowed))


def flips(actions: Actions, winners: Actions, reference: QValues) -> Mask:
    """Where two backends chose differently by more than rounding: bool (n,).

    A flip between two actions whose reference values lie closer than the tolerance is rounding.
    """
    rows = np.arange(len(actions))
    margin = np.abs(reference[rows, winners] - reference[rows, actions])
    scale = np.maximum(1.0, np.abs(reference[rows, winners]))
    mask: Mask = (actions != winners) & (margin > 2 * Q_TOLERANCE * scale)
    return mask


def _read(path: Path) -> bytes:
    try:
        if path.stat().st_size > MAX_FILE_BYTES:
            raise PolicyError(f"{path}: expected a policy of at most 256 MiB, got a larger file")
        return path.read_bytes()
    except OSError as error:
        raise PolicyError(f"{path}: cannot be read: {error.strerror}; give a policy.onnx") from None


def _load(data: bytes, backend: Backend, verify: bool) -> LoadedPolicy:
    model = _parse(data)
    contract = PolicyContract.from_json(_contract_text(model))
    _check_names(model)
    policy = LoadedPolicy(contract, policy_hash(data), data, _build(model, data, backend))
    if verify:
        _reproduce_golden_vectors(policy)
    return policy


def _build(model: onnx.ModelProto, data: bytes, backend: Backend) -> Graph:
    try:
        return NumpyGraph(model) if backend is Backend.NUMPY else OnnxruntimeGraph(data)
    except PolicyError:
        raise
    except Exception as error:  # a damaged file can break any part of it
        raise PolicyError(
            f"the graph is damaged ({type(error).__name__}: {first_line(error)}); export it again"
        ) from None


def _parse(data: bytes) -> onnx.ModelProto:
    try:
        model = onnx.ModelProto.FromString(data)
    except DecodeError:
        raise PolicyError("expected an ONNX model, got something else; export it again") from None
    if not model.graph.node:
        raise PolicyError("expected an ONNX model, got one without a graph; export it again")
    return model


def _contract_text(model: onnx.ModelProto) -> str:
    for entry in model.metadata_props:
        if entry.key == METADATA_KEY:
            return str(entry.value)
    raise ContractError(
        f"expected a reflexarc contract in the ONNX metadata ({METADATA_KEY}), found none; "
        "export the network with `reflexarc export`"
    )


def _check_names(model: onnx.ModelProto) -> None:
    inputs = [value.name for value in model.graph.input]
    outputs = [value.name for value in model.graph.output]
    if inputs != ["retina"] or outputs != ["q_values", "action"]:
        raise PolicyError(
            f"expected input retina and outputs q_values, action; got {inputs} and {outputs}"
        )


def _reproduce_golden_vectors(policy: LoadedPolicy) -> None:
    golden = policy.contract.golden
    if not golden.retinas:
        raise PolicyError("the contract has no golden vectors; export the policy again")
    shape = (len(golden.retinas), *policy.contract.retina.stack_shape)
    q_values, actions = _decide_or_refuse(policy, np.array(golden.retinas, np.uint8).reshape(shape))
    expected = np.array(golden.q_values, np.float32)
    if not _agree(policy.backend, q_values, actions, expected, np.array(golden.actions)):
        raise PolicyError(
            f"golden vectors are not reproduced on {policy.backend}: the weights are not those "
            "that were exported; copy or export the file again"
        )


def _decide_or_refuse(policy: LoadedPolicy, retinas: RetinaBatch) -> tuple[QValues, Actions]:
    try:
        q_values, actions = policy.decide(retinas)
    except Exception as error:  # a graph from outside can fail in any operator
        raise PolicyError(
            f"the graph does not run on {policy.backend}: {first_line(error)}"
        ) from None
    wanted = (len(retinas), len(policy.contract.actions))
    if q_values.shape != wanted or actions.shape != wanted[:1]:
        raise PolicyError(
            f"expected q_values {wanted}, action {wanted[:1]}; got "
            f"{q_values.shape} and {actions.shape}"
        )
    return q_values, actions


def _agree(
    backend: Backend, q_values: QValues, actions: Actions, expected: QValues, winners: Actions
) -> bool:
    if backend is Backend.NUMPY:
        same_bits = q_values.tobytes() == expected.tobytes()
        return same_bits and bool(np.array_equal(actions, winners))
    return within_tolerance(q_values, expected) and not flips(actions, winners, expected).any()
