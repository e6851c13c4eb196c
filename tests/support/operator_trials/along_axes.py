"""Trials of operators that go along axes, and of those that take elements by their places."""

from typing import Any

import numpy as np

from support.operator_trials.trial import Draw, Drawn, Trial, filled, ints


def _reduced(axes_as_input_from: int, *within: float) -> Drawn:
    """Axes as an attribute, or as an input from a version of the operator set on.

    Args:
        within: the lowest and highest number; else a few of which many are equal.
    """

    def draw(from_: Draw) -> Trial:
        shape = from_.shape()
        x = from_.floats(shape, *within) if within else from_.coarse(shape)
        axes, keep = from_.axes(shape), {"keepdims": from_.of(0, 1)}
        if from_.of(True, False):
            old = {**keep, "axes": axes} if axes else keep
            return Trial([x], old, opset=min(17, axes_as_input_from - 1))
        idle = {**keep, "noop_with_empty_axes": from_.of(0, 1)}
        opset = max(17, axes_as_input_from)
        return Trial([x, ints(*axes)], idle if not axes else keep, opset=opset)

    return draw


def _place(from_: Draw) -> Trial:
    shape = from_.shape()
    attributes = {"axis": from_.axis(shape), "keepdims": from_.of(0, 1)}
    return Trial([from_.coarse(shape)], from_.of(attributes, {}))


def _shares(from_: Draw) -> Trial:
    shape = from_.shape()
    new = Trial([from_.floats(shape, -50.0, 50.0)], {"axis": from_.axis(shape)})
    first = {"axis": from_.whole(0, len(shape) - 1)}
    old = Trial(new.inputs, first if len(shape) == 1 else from_.of(first, {}), opset=11)
    return from_.of(new, old, Trial(new.inputs))


def _top(from_: Draw) -> Trial:
    shape = from_.shape()
    axis = from_.axis(shape)
    count = from_.whole(1, shape[axis])
    attributes = {"axis": axis, "largest": from_.of(0, 1), "sorted": 1}
    return Trial([from_.coarse(shape), ints(count)], attributes, outputs=2)


def _running_sum(from_: Draw) -> Trial:
    shape = from_.shape()
    attributes = {"exclusive": from_.of(0, 1), "reverse": from_.of(0, 1)}
    return Trial([from_.coarse(shape), np.array(from_.axis(shape))], attributes)


def _gather(from_: Draw) -> Trial:
    shape = from_.shape()
    axis = from_.axis(shape)
    places = from_.ints(from_.shape(0, 3), -shape[axis], shape[axis] - 1)
    return Trial([filled(shape), places], {"axis": axis})


def _gather_elements(from_: Draw) -> Trial:
    shape = from_.shape()
    axis = from_.axis(shape)
    fewer = [from_.whole(1, side) for side in shape]
    fewer[axis] = from_.whole(1, 5)
    places = from_.ints(fewer, -shape[axis], shape[axis] - 1)
    return Trial([filled(shape), places], {"axis": axis})


def _gather_nd(from_: Draw) -> Trial:
    shape = from_.shape()
    depth = from_.whole(1, len(shape))
    count = from_.whole(1, 3)
    columns = [from_.ints((count,), -side, side - 1) for side in shape[:depth]]
    return Trial([filled(shape), np.stack(columns, -1)])


def _one_hot(from_: Draw) -> Trial:
    shape, depth = from_.shape(1, 3), from_.whole(1, 4)
    axis = from_.whole(-len(shape) - 1, len(shape))
    places = from_.ints(shape, -6, 6)
    values = np.array([0.25, 2.0], np.float32)
    return Trial([places, np.array(depth), values], {"axis": axis})


def _gemm(from_: Draw) -> Trial:
    n, k, m = (from_.whole(1, 4) for _ in range(3))
    turned = {"transA": from_.of(0, 1), "transB": from_.of(0, 1)}
    a = from_.floats((k, n) if turned["transA"] else (n, k))
    b = from_.floats((m, k) if turned["transB"] else (k, m))
    c = [from_.floats(shape) for shape in from_.of([], [(m,)], [(n, m)], [(1, m)], [()])]
    scale = from_.of({}, {"alpha": 0.5}, {"beta": 2.0}, {"alpha": 2.0, "beta": 0.5})
    return Trial([a, b, *c], {**turned, **scale}, tolerance=1e-4)


def _mat_mul(from_: Draw) -> Trial:
    n, k, m = (from_.whole(1, 4) for _ in range(3))
    before = from_.shape(0, 2)
    left: Any = from_.of((k,), (n, k), (*before, n, k))
    right: Any = from_.of((k,), (k, m), (*before, k, m))
    return Trial([from_.floats(left), from_.floats(right)], tolerance=1e-4)


def _einsum(from_: Draw) -> Trial:
    n, k, m = (from_.whole(1, 4) for _ in range(3))
    shapes: dict[str, list[tuple[int, ...]]] = {
        "ij,jk->ik": [(n, k), (k, m)],
        "bij,bkj->bik": [(2, n, k), (2, m, k)],
        "i,j->ij": [(n,), (m,)],
        "ij->ji": [(n, k)],
        "ij->i": [(n, k)],
        "ii->i": [(n, n)],
        "...ij,...jk": [(2, n, k), (2, k, m)],
    }
    equation = from_.of(*shapes)
    inputs: list[Any] = [from_.floats(shape) for shape in shapes[equation]]
    return Trial(inputs, {"equation": equation}, tolerance=1e-4)


ALONG_AXES: dict[str, Drawn] = {
    "ArgMax": _place,
    "ArgMin": _place,
    "CumSum": _running_sum,
    "Einsum": _einsum,
    "Gather": _gather,
    "GatherElements": _gather_elements,
    "GatherND": _gather_nd,
    "Gemm": _gemm,
    "LogSoftmax": _shares,
    "MatMul": _mat_mul,
    "OneHot": _one_hot,
    "ReduceL1": _reduced(18),
    "ReduceL2": _reduced(18),
    "ReduceLogSum": _reduced(18, 0.5, 4.0),
    "ReduceLogSumExp": _reduced(18),
    "ReduceMax": _reduced(18),
    "ReduceMean": _reduced(18),
    "ReduceMin": _reduced(18),
    "ReduceProd": _reduced(18, -1.25, 1.25),
    "ReduceSum": _reduced(13),
    "ReduceSumSquare": _reduced(18),
    "Softmax": _shares,
    "TopK": _top,
}
