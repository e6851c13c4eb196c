"""Every ONNX operator that the NumPy backend has, by name, and the function of a file's node."""

import onnx

from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.operators.activation_operators import ACTIVATIONS
from reflexarc_runtime.policy.operators.elementwise_operators import ELEMENTWISE
from reflexarc_runtime.policy.operators.graph_node import (
    ABSENT,
    ONNX_DOMAINS,
    Maker,
    OnnxNode,
    Operator,
)
from reflexarc_runtime.policy.operators.normalising_operators import NORMALISING
from reflexarc_runtime.policy.operators.picking_operators import PICKING
from reflexarc_runtime.policy.operators.recurrent_operators import RECURRENT
from reflexarc_runtime.policy.operators.reducing_operators import REDUCING
from reflexarc_runtime.policy.operators.shape_operators import SHAPING
from reflexarc_runtime.policy.operators.window_operators import WINDOWS

OPERATORS: dict[str, Maker] = {
    **ACTIVATIONS,
    **ELEMENTWISE,
    **NORMALISING,
    **PICKING,
    **RECURRENT,
    **REDUCING,
    **SHAPING,
    **WINDOWS,
}
"""Name of an ONNX operator → what makes its function from a node."""


def supported_operators() -> tuple[str, ...]:
    """Names of the ONNX operators that the NumPy backend has."""
    return tuple(sorted(OPERATORS))


def operator_of(proto: onnx.NodeProto, opset: int = 17) -> Operator:
    """The function of a node: see `compiled`."""
    return compiled(proto, opset)[1]


def compiled(proto: onnx.NodeProto, opset: int) -> tuple[OnnxNode, Operator]:
    """A node of a file, and its function.

    Args:
        proto: the node.
        opset: the version of ONNX's operator set that says what it means.

    Raises:
        PolicyError: it is another operator, or says something that is not known here.
    """
    kind, is_foreign = proto.op_type, proto.domain not in ONNX_DOMAINS
    attributes = {a.name: onnx.helper.get_attribute_value(a) for a in proto.attribute}
    node = OnnxNode(kind, attributes, given_inputs(proto), tuple(proto.output), opset)
    if kind not in OPERATORS or is_foreign:
        raise PolicyError(
            f"operator {_shown(f'{proto.domain}.' * is_foreign + kind)} "
            f"(node {_shown(proto.name or node.name)!r}) "
            f"is not in the NumPy backend, whose {len(OPERATORS)} operators are listed in "
            "docs/networks.md; use --backend onnxruntime"
        )
    operator = OPERATORS[kind](node)
    if node.unread():
        raise PolicyError(
            f"operator {kind} (node {_shown(proto.name or node.name)!r}): attribute "
            f"{_shown(node.unread()[0])} is not in the NumPy backend; use --backend onnxruntime"
        )
    return node, operator


def _shown(name: str) -> str:
    """A name from a file, short and in one line."""
    return "".join(character if character.isprintable() else "?" for character in name[:60])


def given_inputs(node: onnx.NodeProto) -> tuple[str, ...]:
    """Names of the inputs; absent ones at the end are left to the operator's defaults."""
    names = list(node.input)
    while names and names[-1] == ABSENT:
        names.pop()
    return tuple(names)
