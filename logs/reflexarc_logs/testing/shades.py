"""A retina as lines of text: one line for each eye, brighter is fuller, left is left."""

from collections.abc import Sequence

import numpy as np

SHADES = " ░▒▓█"
MOST_COLUMNS = 64


def retina_lines(stack: bytes, shape: Sequence[int]) -> list[str]:
    """The newest retina of a stack; of neighbouring rays that share a column, the brightest.

    Args:
        stack: what a policy was given.
        shape: (frames, eyes, rays, channels).

    Returns:
        Nothing if the bytes are not of this shape.
    """
    if len(stack) != int(np.prod(shape)):
        return []
    newest = np.frombuffer(stack, np.uint8).reshape(shape)[-1].max(axis=2)
    return [_line(eye) for eye in newest]


def _line(rays: np.ndarray) -> str:
    columns = np.array_split(rays, min(len(rays), MOST_COLUMNS))
    return f"left │{''.join(_shade(int(column.max())) for column in columns)}│ right"


def _shade(value: int) -> str:
    """Nothing is blank; what is little is not nothing."""
    last = len(SHADES) - 1
    return SHADES[min(last, 1 + value * last // 256) if value else 0]
