"""Products of rows of weights with vectors, for the online learner; compiled.

A row is filled up to a whole number of vector registers (`weight_rows.py`), so that the innermost
loops have no remainder.
"""

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.native.decorators import fused_disjoint

Floats = npt.NDArray[np.floating]


@fused_disjoint
def affine_of_two(
    matrix: Floats, bias: Floats, x: Floats, y: Floats, of_x: Floats, of_y: Floats
) -> None:
    """Do of_x = matrixᵀ x + bias and of_y = matrixᵀ y + bias, reading the matrix once.

    Four rows at a time: each pass over the outputs then does eight products.

    Args:
        matrix: (n, m).
        bias: (m,).
        x: (n,).
        y: (n,).
        of_x: filled: (m,).
        of_y: filled: (m,).
    """
    whole = len(x) // 4 * 4
    for h in range(len(bias)):
        of_x[h] = bias[h]
        of_y[h] = bias[h]
    for i in range(0, whole, 4):
        w0, w1, w2, w3 = matrix[i], matrix[i + 1], matrix[i + 2], matrix[i + 3]
        x0, x1, x2, x3 = x[i], x[i + 1], x[i + 2], x[i + 3]
        y0, y1, y2, y3 = y[i], y[i + 1], y[i + 2], y[i + 3]
        for h in range(len(bias)):
            of_x[h] += (w0[h] * x0 + w1[h] * x1) + (w2[h] * x2 + w3[h] * x3)
            of_y[h] += (w0[h] * y0 + w1[h] * y1) + (w2[h] * y2 + w3[h] * y3)
    for i in range(whole, len(x)):
        w0, x0, y0 = matrix[i], x[i], y[i]
        for h in range(len(bias)):
            of_x[h] += w0[h] * x0
            of_y[h] += w0[h] * y0


@fused_disjoint
def dot(row: Floats, x: Floats) -> float:
    """Σ row · x; (m,) each."""
    total = row.dtype.type(0)
    for h in range(len(row)):
        total += row[h] * x[h]
    return float(total)


@fused_disjoint
def scale(factor: float, row: Floats, out: Floats) -> None:
    """Do out = factor · row; (m,) each."""
    number = out.dtype.type(factor)
    for h in range(len(out)):
        out[h] = number * row[h]
