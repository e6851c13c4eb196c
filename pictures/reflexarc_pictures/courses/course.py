"""A course: the path of an agent with what it saw and touched, in snapshots at equal intervals.

Films and pictures of drives are made of it.

Frame: x ahead to the right of a picture, y to the left upwards, metres.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from reflexarc_pictures.log_pictures.logged_poses import Floats
from reflexarc_runtime.contract.contract import PolicyContract

Rgb: TypeAlias = tuple[float, float, float]
"""Red, green, blue, 0 to 1."""

CIRCLE_CORNERS = 36


class Area(NamedTuple):
    """A rectangle of the plane (m)."""

    low_x_m: float
    high_x_m: float
    low_y_m: float
    high_y_m: float


@dataclass(frozen=True)
class Silhouette:
    """The outline of one obstacle, seen from above."""

    corners_m: Floats
    """(corners, 2)."""
    colour: Rgb
    wake_m: tuple[float, float] = (0.0, 0.0)
    """How far it moved within the last second: ahead, left."""


class Scenery(Protocol):
    """The obstacles of a course."""

    def within(self, area: Area, time_s: float) -> Sequence[Silhouette]:
        """The obstacles that reach into an area at a time of the course (s)."""


@dataclass(frozen=True)
class Snapshot:
    """The state of an agent at one time."""

    x_m: float
    y_m: float
    """Its position; where the world repeats, the position goes on without a jump."""
    heading_rad: float
    retina: npt.NDArray[np.uint8] | None
    """Its newest retina: (eyes, rays, channels); None before the first."""
    rays_m: Floats | None
    """Distance along each direction of its eye to the first obstacle, NaN if it is not known:
    (directions,)."""
    contact: bool = False
    """Whether it touched an obstacle since the snapshot before."""
    put: bool = False
    """Whether it was placed here since the snapshot before, without driving here."""


@dataclass(frozen=True)
class Eye:
    """The position and the rays of an eye, relative to the agent."""

    bearings_rad: Floats
    """(directions,)."""
    range_m: float
    left_m: float = 0.0
    """Its distance to the left of the agent's centre."""


@dataclass(frozen=True)
class Course:
    """The snapshots of a course, at least one, and its surroundings."""

    title: str
    period_s: float
    """From one snapshot to the next."""
    snapshots: Sequence[Snapshot]
    eye: Eye
    bright: str
    """What a large value in a retina means."""
    scenery: Scenery
    radius_m: float = 0.0
    """Of the agent."""
    strip_m: tuple[float, float] | None = None
    """Lowest and highest y of the world; None: it has no sides."""
    lateral_period_m: float | None = None
    """Distance to the left after which the world repeats; None: it does not."""
    begins_s: float = 0.0
    """The world's time at the first snapshot."""

    @property
    def contacts(self) -> Sequence[int]:
        """Indices of the snapshots before which a contact began."""
        return [k for k, snapshot in enumerate(self.snapshots) if snapshot.contact]


def eye_of(contract: PolicyContract, bearings_rad: Floats) -> Eye:
    """The first eye of a contract, with these rays."""
    spec = contract.retina
    return Eye(bearings_rad, spec.range_m, spec.baseline_m / 2 if spec.eyes == 2 else 0.0)


def circle(x_m: float, y_m: float, radius_m: float) -> Floats:
    """Corners of a disc: (corners, 2)."""
    angles = np.linspace(0.0, 2 * np.pi, CIRCLE_CORNERS, endpoint=False)
    return np.array([x_m, y_m]) + radius_m * np.stack([np.cos(angles), np.sin(angles)], axis=1)


def reaches_into(corners_m: Floats, area: Area) -> bool:
    """Whether the bounding box of some corners overlaps an area."""
    (low_x, low_y), (high_x, high_y) = corners_m.min(axis=0), corners_m.max(axis=0)
    beside = low_x > area.high_x_m or high_x < area.low_x_m
    return not (beside or low_y > area.high_y_m or high_y < area.low_y_m)
