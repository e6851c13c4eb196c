"""The ONNX file of a policy: its graph, and the contract in its metadata."""

import hashlib
from pathlib import Path

import onnx
from google.protobuf.message import DecodeError

from reflexarc_runtime.contract.contract import METADATA_KEY, PolicyContract
from reflexarc_runtime.errors import ContractError, PolicyError

MAX_FILE_BYTES = 256 << 20


def read_model(path: Path) -> bytes:
    """The bytes of a policy file.

    Raises:
        PolicyError: it cannot be read, or is larger than 256 MiB.
    """
    try:
        check_size(path.stat().st_size)
        return path.read_bytes()
    except PolicyError as error:
        raise PolicyError(f"{path}: {error}") from None
    except OSError as error:
        raise PolicyError(f"{path}: cannot be read: {error.strerror}; give a policy.onnx") from None


def check_size(size_bytes: int) -> None:
    """Check the size of a policy, from wherever it comes.

    Raises:
        PolicyError: it is larger than 256 MiB.
    """
    if size_bytes > MAX_FILE_BYTES:
        raise PolicyError("expected a policy of at most 256 MiB, got a larger one")


def parse_model(data: bytes) -> onnx.ModelProto:
    """The model in these bytes.

    Raises:
        PolicyError: it is no ONNX model, or one without a graph.
    """
    try:
        model = onnx.ModelProto.FromString(data)
    except DecodeError:
        raise PolicyError("expected an ONNX model, got something else; export it again") from None
    if not model.graph.node:
        raise PolicyError("expected an ONNX model, got one without a graph; export it again")
    return model


def contract_text(model: onnx.ModelProto) -> str:
    """The text of the contract in a model's metadata.

    Raises:
        ContractError: there is none, or it is no text.
    """
    try:
        for entry in model.metadata_props:
            if entry.key == METADATA_KEY:
                return str(entry.value)
    except UnicodeDecodeError as error:
        raise ContractError(
            f"contract: expected text in UTF-8, got byte {error.object[error.start]:#04x} at "
            f"{error.start}; the file is damaged: export the policy again"
        ) from None
    raise ContractError(
        f"expected a reflexarc contract in the ONNX metadata ({METADATA_KEY}), found none; "
        "export the network with `reflexarc export`"
    )


def with_contract(model: bytes, contract: PolicyContract) -> bytes:
    """The same ONNX model with `contract` in its metadata, in place of any that was there."""
    proto = parse_model(model)
    kept = [(p.key, p.value) for p in proto.metadata_props if p.key != METADATA_KEY]
    onnx.helper.set_model_props(proto, dict([*kept, (METADATA_KEY, contract.to_json())]))
    return proto.SerializeToString(deterministic=True)


def policy_hash(data: bytes) -> str:
    """Identity of a policy file: its SHA-256, in hexadecimal."""
    return hashlib.sha256(data).hexdigest()


def check_names(model: onnx.ModelProto, contract: PolicyContract) -> None:
    """Check that the graph has the inputs and outputs of its contract.

    Raises:
        PolicyError: others.
    """
    remembers = contract.state.size > 0
    wanted_inputs = ["retina", *["state"] * remembers, *["goal"] * contract.goal]
    wanted_outputs = ["q_values", "action", *["state_next"] * remembers]
    inputs = [value.name for value in model.graph.input]
    outputs = [value.name for value in model.graph.output]
    if inputs != wanted_inputs or outputs != wanted_outputs:
        raise PolicyError(
            f"expected inputs {', '.join(wanted_inputs)} and outputs {', '.join(wanted_outputs)}, "
            f"got {', '.join(inputs)} and {', '.join(outputs)}; contract and graph do not fit: "
            "export the policy again"
        )
