"""What every kind of file tells of its image, and the complaint of one that cannot be read."""

from dataclasses import dataclass


class UnreadableImageError(Exception):
    """A file whose image cannot be shown truly. Its text continues the file's name: "is cut"."""


@dataclass(frozen=True, slots=True)
class Facts:
    """What decoding needs to know, and OpenCV does not tell."""

    orientation: int = 1
    """As Exif counts (CIPA DC-008, tag 0x0112): 1 is upright, 6 must turn to the right."""
    white: int | None = None
    """The value of white in the decoded numbers, where the file says it."""
    transparent: bool = False
    """One colour stands for "transparent", which OpenCV would show as that colour."""
    pads_colours: bool = False
    """A fourth channel is padding and no transparency."""
    width: int = 0
    """Columns that it says it has; 0: it does not say."""
    height: int = 0
    """Rows that it says it has."""
