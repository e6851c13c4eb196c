"""What a viewer draws, in plain values: pictures, points, shapes, curves, words.

Lengths are metres, angles radians, in a right-handed frame with z up. `place` says where in the
viewer's tree a thing stands: "world/robot/scan".
"""

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Places: TypeAlias = npt.NDArray[np.float64]
"""Shape (n, 3)."""
Colours: TypeAlias = npt.NDArray[np.uint8]
"""Red, green, blue, opacity: (n, 4)."""

WORLD = "world"
SCENE = "world/scene"
PATH = "world/path"
"""Where the robot has just been."""
WAY = "world/way"
"""All of its way, at all times."""
ROBOT = "world/robot"
SCAN = "world/robot/scan"
RETINA = "retina"
IMAGES = "images"
Q_VALUES = "q_values"
COMMAND = "command"
EVENTS = "events"


@dataclass(frozen=True)
class DrawnPicture:
    """An image of uint8: (rows, columns) or (rows, columns, 3 or 4)."""

    place: str
    pixels: npt.NDArray[np.uint8]


@dataclass(frozen=True)
class DrawnFile:
    """An image as a file holds it."""

    place: str
    data: bytes
    media_type: str


@dataclass(frozen=True)
class DrawnPoints:
    """Points in space."""

    place: str
    points_m: Places


@dataclass(frozen=True)
class DrawnLine:
    """A line through points."""

    place: str
    points_m: Places


@dataclass(frozen=True)
class DrawnFrame:
    """Where the frame of a place is in that of the place above it, turned about z."""

    place: str
    x_m: float
    y_m: float
    heading_rad: float


@dataclass(frozen=True)
class DrawnBoxes:
    """Boxes along the axes."""

    place: str
    centres_m: Places
    sizes_m: Places
    colours: Colours


@dataclass(frozen=True)
class DrawnDiscs:
    """Upright cylinders."""

    place: str
    centres_m: Places
    radii_m: npt.NDArray[np.float64]
    heights_m: npt.NDArray[np.float64]
    colours: Colours


@dataclass(frozen=True)
class DrawnTriangles:
    """Triangles: three corners each, (3 n, 3), a colour for each corner."""

    place: str
    corners_m: Places
    colours: Colours


@dataclass(frozen=True)
class DrawnNumbers:
    """One value for each of some curves."""

    place: str
    values: tuple[float, ...]


@dataclass(frozen=True)
class DrawnWords:
    """Something that was said."""

    place: str
    text: str
    level: str = "INFO"
    """INFO, WARN or ERROR."""


Drawing: TypeAlias = (
    DrawnPicture
    | DrawnFile
    | DrawnPoints
    | DrawnLine
    | DrawnFrame
    | DrawnBoxes
    | DrawnDiscs
    | DrawnTriangles
    | DrawnNumbers
    | DrawnWords
)
