"""ONNX operators that slide a window over space: convolution and pooling, in any dimensions.

Arrays are (n, channels, *space). A window of `kernel` elements, `dilations` apart, moves by
`strides` over space with `pads` around it:

    positions along an axis = (size + pads − ((kernel − 1) · dilation + 1)) / stride + 1
"""

from typing import NamedTuple

import numpy as np

from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.operators.graph_node import Maker, OnnxNode, Operator, Tensor


class SlidingWindow(NamedTuple):
    """How a window moves; one number an axis of space, two of the pads."""

    kernel: tuple[int, ...]
    strides: tuple[int, ...]
    dilations: tuple[int, ...]
    auto_pad: str
    pads: tuple[int, ...]
    is_ceil: bool
    """Whether a last position counts that does not lie wholly in the padded space."""

    @property
    def spans(self) -> tuple[int, ...]:
        """From the first element of a window to behind its last one."""
        pairs = zip(self.kernel, self.dilations, strict=True)
        return tuple((k - 1) * d + 1 for k, d in pairs)

    def around(self, space: tuple[int, ...]) -> list[tuple[int, int]]:
        """The padding before and behind each axis."""
        if self.auto_pad in ("NOTSET", "VALID"):
            pads = self.pads if self.auto_pad == "NOTSET" else (0, 0) * len(space)
            return list(zip(pads[: len(space)], pads[len(space) :], strict=True))
        around = []
        for size, span, stride in zip(space, self.spans, self.strides, strict=True):
            missing = max((-(-size // stride) - 1) * stride + span - size, 0)
            less, more = missing // 2, missing - missing // 2
            around.append((less, more) if self.auto_pad == "SAME_UPPER" else (more, less))
        return around

    def positions(self, space: tuple[int, ...]) -> tuple[int, ...]:
        """How many positions there are along each axis of space."""
        found = []
        for axis, (before, behind) in enumerate(self.around(space)):
            room, stride = space[axis] + before + behind - self.spans[axis], self.strides[axis]
            count = (-(-room // stride) if self.is_ceil else room // stride) + 1
            # A position that begins in the padding behind is none.
            found.append(count - (self.is_ceil and (count - 1) * stride >= space[axis] + before))
        if min(found) < 1:
            raise PolicyError(f"a window of {self.spans} is larger than {space} and its padding")
        return tuple(found)

    def over(self, x: Tensor, filler: float | int | bool) -> Tensor:
        """What lies in the window at each position: (n, channels, *positions, *kernel)."""
        space = x.shape[2:]
        counts, around = self.positions(space), self.around(space)
        added = [(0, 0), (0, 0)]
        for axis, (before, behind) in enumerate(around):
            reach = (counts[axis] - 1) * self.strides[axis] + self.spans[axis]
            added.append((before, max(behind, reach - space[axis] - before)))
        padded = np.pad(x, added, constant_values=filler)
        axes = tuple(range(2, x.ndim))
        view = np.lib.stride_tricks.sliding_window_view(padded, self.spans, axes)
        moves = [slice(0, c * s, s) for c, s in zip(counts, self.strides, strict=True)]
        gaps = [slice(None, None, dilation) for dilation in self.dilations]
        windows: Tensor = view[(slice(None), slice(None), *moves, *gaps)]
        return windows


def window_of(node: OnnxNode, kernel: tuple[int, ...]) -> SlidingWindow:
    """The window that a node's attributes describe."""
    rank = len(kernel)
    auto_pad = node.word("auto_pad", "NOTSET")
    if auto_pad not in ("NOTSET", "VALID", "SAME_UPPER", "SAME_LOWER"):
        raise PolicyError(f"operator {node.kind}: auto_pad={auto_pad} is not known")
    strides = tuple(node.get("strides", (1,) * rank))
    dilations = tuple(node.get("dilations", (1,) * rank))
    pads = tuple(node.get("pads", (0, 0) * rank))
    fits = (len(strides), len(dilations), len(pads)) == (rank, rank, 2 * rank)
    if not rank or not fits or min(*kernel, *strides, *dilations) < 1 or min(pads) < 0:
        raise PolicyError(f"operator {node.kind}: kernel, strides, dilations and pads do not fit")
    return SlidingWindow(kernel, strides, dilations, auto_pad, pads, bool(node.get("ceil_mode", 0)))


def _conv(node: OnnxNode) -> Operator:
    group = node.get("group", 1)
    # The weights have the kernel's shape; with it the others are read.
    node.passes_over("kernel_shape", "auto_pad", "strides", "dilations", "pads")

    def conv(x: Tensor, w: Tensor, b: Tensor | None = None) -> Tensor:
        windows = window_of(node, w.shape[2:]).over(x, 0.0)
        parts = zip(np.split(windows, group, 1), np.split(w, group, 0), strict=True)
        sums = np.concatenate([_weighted(part, weights) for part, weights in parts], axis=1)
        return sums if b is None else sums + b.reshape(-1, *[1] * (x.ndim - 2))

    return conv


def _weighted(windows: Tensor, w: Tensor) -> Tensor:
    """Sums over channels and kernel: (n, *positions, outputs), with the outputs put second."""
    rank = w.ndim - 2
    inside = (1, *range(2 + rank, 2 + 2 * rank))
    sums = np.tensordot(windows, w, (inside, tuple(range(1, w.ndim))))
    return np.moveaxis(sums, -1, 1)


def _max_pool(node: OnnxNode) -> Operator:
    node.passes_over("storage_order")  # of places, which are not given
    window = window_of(node, tuple(node["kernel_shape"]))

    def pool(x: Tensor) -> Tensor:
        lowest = -np.inf if x.dtype.kind == "f" else np.iinfo(x.dtype).min
        highest: Tensor = window.over(x, lowest).max(axis=_inside(x))
        return highest

    return pool


def _average_pool(node: OnnxNode) -> Operator:
    window = window_of(node, tuple(node["kernel_shape"]))
    counts_padding = bool(node.get("count_include_pad", 0))
    if counts_padding:
        node.require("ceil_mode", 0, "with count_include_pad=1 versions differ in what they count")

    def pool(x: Tensor) -> Tensor:
        sums = window.over(x, 0.0).sum(axis=_inside(x))
        if counts_padding:
            counts = np.array(np.prod(window.kernel))
        else:
            counts = window.over(np.ones((1, 1, *x.shape[2:])), 0.0).sum(axis=_inside(x))
        result: Tensor = sums / counts
        return result

    return pool


def _global(operator: Operator) -> Maker:
    def make(_: OnnxNode) -> Operator:
        return lambda x: operator(x, axis=tuple(range(2, x.ndim)), keepdims=True)

    return make


def _inside(x: Tensor) -> tuple[int, ...]:
    """The axes of a window in what `SlidingWindow.over` gives for `x`."""
    return tuple(range(x.ndim, 2 * x.ndim - 2))


WINDOWS: dict[str, Maker] = {
    "AveragePool": _average_pool,
    "Conv": _conv,
    "GlobalAveragePool": _global(np.mean),
    "GlobalMaxPool": _global(np.max),
    "MaxPool": _max_pool,
}
"""Name of an ONNX operator → what makes its function from a node."""
