"""Calibration of a camera: its rows, its lens, and the colours of obstacles. A small TOML file.

[band]                         # which rows count, as shares of the height from the top
top = 0.45
bottom = 0.55

[lens]                         # without it, equal shares of the columns become the rays
fov_rad = 2.0                  # from the left to the right edge of the image of one eye
projection = "pinhole"         # or "equidistant", as fisheye lenses nearly are

[background]                   # a pixel near this colour is background, any other an obstacle
colour = [200, 200, 190]       # red, green, blue
tolerance = 60.0               # distance in RGB, of at most 441.7

[obstacle]                     # in place of a background: a pixel between these colours
lowest = [150, 0, 0]
highest = [255, 90, 90]
"""

import math
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path

from reflexarc_runtime.config.checks import require
from reflexarc_runtime.config.fill import fill
from reflexarc_runtime.config.toml_source import TomlSource, read_text

MAX_DISTANCE = math.sqrt(3 * 255**2)
"""Distance in RGB from black to white."""

Colour = tuple[int, int, int]
"""Red, green, blue, each 0 to 255."""


class Projection(StrEnum):
    """How a lens maps a bearing to a column, with f in pixels from the optical axis."""

    PINHOLE = "pinhole"
    """f · tan(bearing)."""
    EQUIDISTANT = "equidistant"
    """f · bearing."""


@dataclass(frozen=True)
class Band:
    """The rows that are looked at, as shares of the image's height from the top."""

    top: float = 0.45
    bottom: float = 0.55

    def __post_init__(self) -> None:
        require(0.0 <= self.top <= 1.0, "band.top", "0 to 1", self.top)
        require(self.top < self.bottom <= 1.0, "band.bottom", "top to 1", self.bottom)


@dataclass(frozen=True)
class Lens:
    """The lens of one eye, whose axis meets the middle column."""

    fov_rad: float
    """From the left to the right edge of the image."""
    projection: Projection = Projection.PINHOLE

    def __post_init__(self) -> None:
        limit_rad = math.pi if self.projection is Projection.PINHOLE else 2.0 * math.pi
        inside = 0.0 < self.fov_rad < limit_rad
        require(inside, "lens.fov_rad", f"in (0, {limit_rad:.2f})", self.fov_rad)


@dataclass(frozen=True)
class Background:
    """The colour of the background: any other pixel belongs to an obstacle."""

    colour: Colour = (0, 0, 0)
    tolerance: float = 60.0
    """Euclidean distance in RGB up to which a pixel is still background."""

    def __post_init__(self) -> None:
        _check_colour("background.colour", self.colour)
        inside = 0.0 <= self.tolerance <= MAX_DISTANCE
        require(inside, "background.tolerance", f"0 to {MAX_DISTANCE:.1f}", self.tolerance)


@dataclass(frozen=True)
class ColourRange:
    """The colours of obstacles."""

    lowest: Colour
    highest: Colour

    def __post_init__(self) -> None:
        _check_colour("obstacle.lowest", self.lowest)
        _check_colour("obstacle.highest", self.highest)
        ordered = all(low <= high for low, high in zip(self.lowest, self.highest, strict=True))
        require(ordered, "obstacle.highest", "no channel below lowest", self.highest)


@dataclass(frozen=True)
class Calibration:
    """Everything about one camera."""

    band: Band = field(default_factory=Band)
    lens: Lens | None = None
    """None: equal shares of the columns become the rays, the leftmost is ray 0."""
    obstacle: Background | ColourRange = field(default_factory=Background)
    """How an obstacle is told from the background."""


def read_calibration(path: Path) -> Calibration:
    """Read a calibration from a TOML file.

    Raises:
        UsageError: the file cannot be read, or describes no valid calibration.
    """
    name = f"--calibration: {path}"
    return parse_calibration(read_text(path, name), name)


def parse_calibration(text: str, name: str = "") -> Calibration:
    """Read a calibration from TOML text.

    Args:
        text: the TOML.
        name: how complaints name it.

    Raises:
        UsageError: it is not TOML, or a field is missing, unknown, of the wrong type or out of
            range.
    """
    file = fill(_File, TomlSource(text, name))
    return Calibration(file.band, file.lens, file.obstacle or file.background or Background())


@dataclass(frozen=True)
class _File:
    """A calibration as its file has it: the colours of obstacles, or of the background."""

    band: Band = field(default_factory=Band)
    lens: Lens | None = None
    background: Background | None = None
    obstacle: ColourRange | None = None

    def __post_init__(self) -> None:
        one = self.background is None or self.obstacle is None
        require(one, "obstacle", "background or obstacle, one of the two", "both")


def _check_colour(where: str, colour: Colour) -> None:
    good = all(0 <= value <= 255 for value in colour)
    require(good, where, "three whole numbers, 0 to 255", list(colour))
