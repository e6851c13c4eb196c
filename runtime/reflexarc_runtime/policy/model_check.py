"""Whether a model is whole and in order, before anything of it is built.

Both backends give the same answer here. Each by itself would open files beside the policy, fail
with a name that says nothing, or compute in an order of its own.
"""

from collections.abc import Iterator
from itertools import chain

import onnx

from reflexarc_runtime.errors import PolicyError

MOST_NODES = 10_000
MOST_WEIGHTS = 1 << 24
"""Numbers in the file, all constants together; 64 MiB of float32."""
_NAME_CHARACTERS = 60


def check_model(model: onnx.ModelProto) -> None:
    """Check that a model has its weights within, each value once, and its nodes in order.

    Raises:
        PolicyError: the first thing that is not so.
    """
    nodes = list(_nodes_of(model))
    tensors = list(_tensors_of(model, nodes))
    _check_names(model.graph, nodes)
    _check_location(tensors)
    _check_sizes(model, nodes, tensors)
    _check_order(model.graph)


def quoted(name: str) -> str:
    """A name from a file, fit to be shown: in quotes, short, in one line."""
    return repr(name if len(name) <= _NAME_CHARACTERS else f"{name[:_NAME_CHARACTERS]}…")


def _nodes_of(model: onnx.ModelProto) -> Iterator[onnx.NodeProto]:
    """All nodes, those of functions and of graphs within nodes too."""
    open_nodes = list(chain(model.graph.node, *(function.node for function in model.functions)))
    while open_nodes:
        node = open_nodes.pop()
        yield node
        for attribute in node.attribute:
            for graph in (attribute.g, *attribute.graphs):
                open_nodes.extend(graph.node)


def _tensors_of(model: onnx.ModelProto, nodes: list[onnx.NodeProto]) -> Iterator[onnx.TensorProto]:
    """All constants, wherever they stand."""
    yield from _constants(model.graph)
    for attribute in chain.from_iterable(node.attribute for node in nodes):
        yield from (attribute.t, *attribute.tensors)
        for sparse in (attribute.sparse_tensor, *attribute.sparse_tensors):
            yield from (sparse.values, sparse.indices)
        for graph in (attribute.g, *attribute.graphs):
            yield from _constants(graph)


def _constants(graph: onnx.GraphProto) -> Iterator[onnx.TensorProto]:
    yield from graph.initializer
    for sparse in graph.sparse_initializer:
        yield from (sparse.values, sparse.indices)


def _check_names(graph: onnx.GraphProto, nodes: list[onnx.NodeProto]) -> None:
    """A name that is no text comes as bytes, or not at all, as the version of protobuf has it."""
    names = [tensor.name for tensor in graph.initializer]
    names += [value.name for value in (*graph.input, *graph.output)]
    for node in nodes:
        names += [node.name, node.op_type, node.domain, *node.input, *node.output]
        names += [attribute.name for attribute in node.attribute]
    if not all(isinstance(name, str) for name in names):
        raise PolicyError("a name in it is no text; it is damaged: export it again")


def _check_location(tensors: list[onnx.TensorProto]) -> None:
    for tensor in tensors:
        if tensor.data_location == onnx.TensorProto.EXTERNAL or tensor.external_data:
            places = [entry.value for entry in tensor.external_data if entry.key == "location"]
            where = quoted(places[0]).strip("'\"") if places and places[0] else "another file"
            raise PolicyError(
                f"its weights lie in {where}; embed them: onnx.save(onnx.load(FILE), OUT), where "
                "both files lie, then export it again"
            )


def _check_sizes(
    model: onnx.ModelProto, nodes: list[onnx.NodeProto], tensors: list[onnx.TensorProto]
) -> None:
    if len(nodes) > MOST_NODES:
        raise PolicyError(f"expected at most {MOST_NODES} nodes, got {len(nodes)}")
    sparse = [tuple(each.dims) for each in model.graph.sparse_initializer]
    shapes = [tuple(tensor.dims) for tensor in tensors] + sparse
    for dims in shapes:
        if any(size < 0 for size in dims):
            raise PolicyError(f"a constant has the shape {dims[:8]}: no side can be negative")
    total = sum(_product(dims) for dims in shapes)
    if total > MOST_WEIGHTS:
        raise PolicyError(f"expected at most {MOST_WEIGHTS} weights, got {total:.4g}")


def _product(dims: tuple[int, ...]) -> int:
    product = 1
    for size in dims:
        product = min(product * size, 1 << 62)
    return product if dims else 1


def _check_order(graph: onnx.GraphProto) -> None:
    """Each value is made once, and before it is read."""
    known = {""}
    for name in chain((t.name for t in graph.initializer), _sparse_names(graph)):
        if name in known:
            raise PolicyError(f"two weights are called {quoted(name)}; export it again")
        known.add(name)
    known.update(value.name for value in graph.input)
    later = {name for node in graph.node for name in node.output}
    for node in graph.node:
        _check_reads(node, known, later)
        for name in filter(None, node.output):
            if name in known:
                raise PolicyError(f"{quoted(name)} is made twice in its graph; export it again")
            known.add(name)
    for value in graph.output:
        if value.name not in known:
            raise PolicyError(f"no node makes its output {quoted(value.name)}; export it again")


def _check_reads(node: onnx.NodeProto, known: set[str], later: set[str]) -> None:
    for name in node.input:
        if name in known:
            continue
        who = f"node {quoted(node.name or next(iter(node.output), ''))} ({quoted(node.op_type)})"
        if name in later:
            raise PolicyError(
                f"its nodes are not in order: {who} reads {quoted(name)}, which a later node "
                "makes; sort them, or export it again"
            )
        raise PolicyError(f"{who} reads {quoted(name)}, which nothing makes; export it again")


def _sparse_names(graph: onnx.GraphProto) -> Iterator[str]:
    return (sparse.values.name for sparse in graph.sparse_initializer)
