"""Names for the NumPy arrays that the packages exchange, with their shapes.

Shapes are checked where data enters a process.
"""

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Retina: TypeAlias = npt.NDArray[np.uint8]
"""One retina: (eyes, rays, channels)."""

RetinaStack: TypeAlias = npt.NDArray[np.uint8]
"""What a policy sees at one tick: (frames, eyes, rays, channels), oldest frame first."""

RetinaBatch: TypeAlias = npt.NDArray[np.uint8]
"""Stacks of many ticks: (n, frames, eyes, rays, channels)."""

QValues: TypeAlias = npt.NDArray[np.float32]
"""Action values: (n, actions)."""

Actions: TypeAlias = npt.NDArray[np.int64]
"""Indices into the contract's actions: (n,)."""

Ranges: TypeAlias = npt.NDArray[np.float64]
"""Distances of one scan in metres, counter-clockwise: (beams,)."""

Mask: TypeAlias = npt.NDArray[np.bool_]
"""A truth value for each of n items: (n,)."""

Memories: TypeAlias = npt.NDArray[np.float32]
"""What policies with a memory carry from one input to the next: (n, size)."""
