r"""A block of agents through the network, forwards and backwards; compiled, in either precision.

A column is an agent. All innermost loops run over the columns of a block, so that they become
vector instructions whatever the sizes of the layers. With x the inputs (inputs, columns) of a
layer, it computes

    z = W x + b,    y = f(z),

and backwards (backpropagation), from ∂L/∂y of the last layer,

    ∂L/∂z = ∂L/∂y · f′,    ∂L/∂W = ∂L/∂z xᵀ,    ∂L/∂b = Σ ∂L/∂z,    ∂L/∂x = Wᵀ ∂L/∂z.

The weights are one vector in the order of `policy/weights.py`: for each layer W as rows (outputs,
inputs), then b.
"""

from typing import Any

import numpy.typing as npt

from reflexarc_sim_bridge.native.decorators import fused, fused_free
from reflexarc_trainer.sarsa.network_shape import Layers
from reflexarc_trainer.sarsa.units import activate, times_slope

Block = npt.NDArray[Any]
"""A number per unit and agent, float32 or float64: (units, columns)."""


@fused
def forward(layers: Layers, weights: npt.NDArray[Any], inputs: Block, values: Block) -> None:
    """Compute the activations of all layers.

    Args:
        layers: shape of the network.
        weights: (parameters,).
        inputs: (inputs, columns).
        values: filled, layer after layer; the last rows are the Q-values: (computed, columns).
    """
    below, row, at = inputs, 0, 0
    for layer in range(len(layers.sizes) - 1):
        n_in, n_out = layers.sizes[layer], layers.sizes[layer + 1]
        here = values[row : row + n_out]
        _multiply(weights[at : at + n_in * n_out].reshape(n_out, n_in), below, here)
        at += n_in * n_out
        _add_biases(weights[at : at + n_out], here)
        last = layer == len(layers.sizes) - 2
        activate(layers.output if last else layers.units, here.reshape(here.size))
        below, row, at = here, row + n_out, at + n_out


@fused_free
def forward_from_python(
    layers: Layers, weights: npt.NDArray[Any], inputs: Block, values: Block
) -> None:
    """`forward` for callers that are not compiled."""
    forward(layers, weights, inputs, values)


@fused
def backward(
    layers: Layers,
    weights: npt.NDArray[Any],
    inputs: Block,
    values: Block,
    back: Block,
    gradient: npt.NDArray[Any],
) -> None:
    """Add ∂L/∂weights of a block to a gradient.

    Args:
        layers: shape of the network.
        weights: (parameters,).
        inputs: (inputs, columns).
        values: what `forward` filled: (computed, columns).
        back: ∂L/∂Q in the last rows; the others are filled: (computed, columns).
        gradient: added to: (parameters,).
    """
    row, at = len(values), len(weights)
    for layer in range(len(layers.sizes) - 2, -1, -1):
        n_in, n_out = layers.sizes[layer], layers.sizes[layer + 1]
        row, at = row - n_out, at - (n_in + 1) * n_out
        here, down = values[row : row + n_out], back[row : row + n_out]
        last = layer == len(layers.sizes) - 2
        units = layers.output if last else layers.units
        times_slope(units, here.reshape(here.size), down.reshape(down.size))
        bias = at + n_in * n_out
        matrix = gradient[at:bias].reshape(n_out, n_in)
        below = inputs if layer == 0 else values[row - n_in : row]
        _add_products(down, below, matrix, gradient[bias : bias + n_out])
        if layer > 0:
            _multiply(weights[at:bias].reshape(n_out, n_in).T, down, back[row - n_in : row])


@fused
def _add_biases(biases: npt.NDArray[Any], out: Block) -> None:
    """Add biases (units,) to every column."""
    for h in range(out.shape[0]):
        bias = biases[h]
        for c in range(out.shape[1]):
            out[h, c] += bias


@fused
def _multiply(matrix: npt.NDArray[Any], x: Block, out: Block) -> None:
    """Do out = matrix · x, four inputs at a time: a pass over a row of `out` adds four products."""
    n_out, n_in = matrix.shape
    whole = n_in // 4 * 4
    for h in range(n_out):
        row = out[h]
        row[:] = 0
        for i in range(0, whole, 4):
            w0, w1, w2, w3 = matrix[h, i], matrix[h, i + 1], matrix[h, i + 2], matrix[h, i + 3]
            x0, x1, x2, x3 = x[i], x[i + 1], x[i + 2], x[i + 3]
            for c in range(len(row)):
                row[c] += (w0 * x0[c] + w1 * x1[c]) + (w2 * x2[c] + w3 * x3[c])
        for i in range(whole, n_in):
            w0, x0 = matrix[h, i], x[i]
            for c in range(len(row)):
                row[c] += w0 * x0[c]


@fused
def _add_products(down: Block, below: Block, matrix: Block, biases: npt.NDArray[Any]) -> None:
    """Do matrix += down · belowᵀ, four inputs at a time, and biases += Σ down over the columns."""
    n_in, zero = below.shape[0], matrix.dtype.type(0)
    whole = n_in // 4 * 4
    for h in range(down.shape[0]):
        row = down[h]
        for i in range(0, whole, 4):
            x0, x1, x2, x3 = below[i], below[i + 1], below[i + 2], below[i + 3]
            s0 = s1 = s2 = s3 = zero
            for c in range(len(row)):
                s0 += row[c] * x0[c]
                s1 += row[c] * x1[c]
                s2 += row[c] * x2[c]
                s3 += row[c] * x3[c]
            matrix[h, i] += s0
            matrix[h, i + 1] += s1
            matrix[h, i + 2] += s2
            matrix[h, i + 3] += s3
        for i in range(whole, n_in):
            x0, s0 = below[i], zero
            for c in range(len(row)):
                s0 += row[c] * x0[c]
            matrix[h, i] += s0
        s0 = zero
        for c in range(len(row)):
            s0 += row[c]
        biases[h] += s0
