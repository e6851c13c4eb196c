"""The ONNX file of a policy: its graph, and the contract in its metadata."""

import hashlib
from pathlib import Path

import onnx
from google.protobuf.message import DecodeError

from reflexarc_runtime.contract.contract import METADATA_KEY, PolicyContract
from reflexarc_runtime.errors import ContractError, PolicyError
from reflexarc_runtime.files import is_lfs_pointer, read_at_most
from reflexarc_runtime.policy.model_check import check_model, quoted
from reflexarc_runtime.policy.wire_check import check_wire

MAX_FILE_BYTES = 64 << 20
"""Of a policy: read, parsed and widened it takes a few times as much."""
MAX_CONTRACT_CHARACTERS = 24 << 20
"""Of the contract in it: sixteen golden vectors of the largest retina take 4 MiB a frame."""
MAX_CONTRACT_PARTS = 1 << 17
"""Lists, tables and half of the quotes in it; each takes some fifty bytes in memory."""


def read_model(path: Path) -> bytes:
    """The bytes of a policy file.

    Raises:
        PolicyError: it cannot be read, is larger than 64 MiB, or what Git LFS left in its place.
    """
    try:
        data = read_at_most(path, MAX_FILE_BYTES)  # a device has no size, and no end
        check_size(len(data))
        if is_lfs_pointer(data):
            raise PolicyError("is a Git LFS pointer, not the policy itself: `git lfs pull`")
        return data
    except PolicyError as error:
        raise PolicyError(f"{path}: {error}") from None
    except OSError as error:
        raise PolicyError(f"{path}: cannot be read: {error.strerror}; give a policy.onnx") from None


def check_size(size_bytes: int) -> None:
    """Check the size of a policy, from wherever it comes.

    Raises:
        PolicyError: it is larger than 64 MiB.
    """
    if size_bytes > MAX_FILE_BYTES:
        raise PolicyError("expected a policy of at most 64 MiB, got a larger one")


def parse_model(data: bytes) -> onnx.ModelProto:
    """The model in these bytes.

    Raises:
        PolicyError: it is no ONNX model, one without a graph, too large, or not in order.
    """
    check_size(len(data))
    check_wire(data)
    try:
        model = onnx.ModelProto.FromString(data)
    except DecodeError:
        raise PolicyError("expected an ONNX model, got something else; export it again") from None
    if not model.graph.node:
        raise PolicyError("expected an ONNX model, got one without a graph; export it again")
    try:
        check_model(model)
    except UnicodeDecodeError:
        raise PolicyError("a name in it is no text; it is damaged: export it again") from None
    return model


def contract_text(model: onnx.ModelProto) -> str:
    """The text of the contract in a model's metadata.

    Raises:
        ContractError: there is none, or it is no text.
    """
    try:
        for entry in model.metadata_props:
            if entry.key == METADATA_KEY:
                return _small(str(entry.value))
    except UnicodeDecodeError as error:
        raise ContractError(
            f"contract: expected text in UTF-8, got byte {error.object[error.start]:#04x} at "
            f"{error.start}; the file is damaged: export the policy again"
        ) from None
    raise ContractError(
        f"expected a reflexarc contract in the ONNX metadata ({METADATA_KEY}), found none; "
        "export the network with `reflexarc export`"
    )


def _small(text: str) -> str:
    """The text, if it can be read without harm: JSON unfolds in memory."""
    parts = text.count("[") + text.count("{") + text.count('"') // 2
    if len(text) > MAX_CONTRACT_CHARACTERS or parts > MAX_CONTRACT_PARTS:
        raise ContractError(
            f"contract: expected at most {MAX_CONTRACT_CHARACTERS >> 20} MiB and "
            f"{MAX_CONTRACT_PARTS} lists, tables and words, got {len(text)} characters and "
            f"{parts} parts"
        )
    return text


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
    # Older exporters list the weights among the inputs too.
    weights = {t.name for t in model.graph.initializer} - set(wanted_inputs)
    inputs = [value.name for value in model.graph.input if value.name not in weights]
    outputs = [value.name for value in model.graph.output]
    if inputs != wanted_inputs or outputs != wanted_outputs:
        raise PolicyError(
            f"expected inputs {', '.join(wanted_inputs)} and outputs {', '.join(wanted_outputs)}, "
            f"got {_listed(inputs)} and {_listed(outputs)}; contract and graph do not fit: "
            "export the policy again"
        )
    _check_retina(model, contract)


def _listed(names: list[str]) -> str:
    """Some names from a file, in one line."""
    shown = [name if name.isidentifier() and len(name) < 60 else quoted(name) for name in names[:8]]
    return ", ".join([*shown, f"{len(names) - 8} more"] if len(names) > 8 else shown) or "none"


def _check_retina(model: onnx.ModelProto, contract: PolicyContract) -> None:
    """Check that what the graph declares to see is what it will be given."""
    (declared,) = [value.type.tensor_type for value in model.graph.input if value.name == "retina"]
    if declared.elem_type != onnx.TensorProto.UINT8:
        known = onnx.TensorProto.DataType
        kind = declared.elem_type
        raise PolicyError(
            "expected a retina of type UINT8, got "
            f"{known.Name(kind) if kind in known.values() else 'another'}: the graph has to turn "
            "intensities 0 to 255 into what the network wants; export the policy again"
        )
    sides = [side.dim_value for side in declared.shape.dim]
    wanted = (0, *contract.retina.stack_shape)
    fits = all(side in (0, size) for side, size in zip(sides[1:], wanted[1:], strict=False))
    if declared.HasField("shape") and not (fits and len(sides) == len(wanted)):
        raise PolicyError(
            f"expected a retina (n, {', '.join(map(str, wanted[1:]))}) as its contract says, got "
            f"{tuple(sides[:8])}; contract and graph do not fit: export the policy again"
        )
