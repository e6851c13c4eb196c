"""Whether two backends agree: what counts as rounding, and what as another decision."""

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.arrays import Actions, Mask, QValues

Q_TOLERANCE = 1e-6
"""Largest difference between onnxruntime and the reference, times the larger of 1 and |Q|, where
the contract does not say another."""

Floats: TypeAlias = npt.NDArray[np.float32]


def within_tolerance(values: Floats, reference: Floats, tolerance: float = Q_TOLERANCE) -> bool:
    """Whether two sets of values are finite and as close as those of two backends must be."""
    if not (np.isfinite(values).all() and np.isfinite(reference).all()):
        return False
    allowed = tolerance * np.maximum(1.0, np.abs(reference))
    return bool(np.all(np.abs(values - reference) <= allowed))


def flips(
    actions: Actions, winners: Actions, reference: QValues, tolerance: float = Q_TOLERANCE
) -> Mask:
    """Where two backends chose differently by more than rounding: bool (n,).

    A flip between two actions whose reference values lie closer than the tolerance is rounding.
    """
    rows = np.arange(len(actions))
    margin = np.abs(reference[rows, winners] - reference[rows, actions])
    scale = np.maximum(1.0, np.abs(reference[rows, winners]))
    mask: Mask = (actions != winners) & (margin > 2 * tolerance * scale)
    return mask
