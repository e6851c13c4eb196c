"""A course: what an agent came past, saw and touched, moment by moment; what a film shows.

Frame: x ahead to the right of a picture, y to the left upwards, metres.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.contract import PolicyContract

Floats: TypeAlias = npt.NDArray[np.float64]
Rgb: TypeAlias = tuple[float, float, float]
"""Red, green, blue, 0 to 1."""

CIRCLE_CORNERS = 36


class Area(NamedTuple):
    """A part of the plane (m)."""

    low_x_m: float
    high_x_m: float
    low_y_m: float
    high_y_m: float


@dataclass(frozen=True)
class Silhouette:
    """One obstacle from above."""

    corners_m: Floats
    """(corners, 2)."""
    colour: Rgb
    wake_m: tuple[float, float] = (0.0, 0.0)
    """How far it moved within the last second: ahead, left."""


class Scenery(Protocol):
    """What stands around."""

    def within(self, area: Area, time_s: float) -> Sequence[Silhouette]:
        """What reaches into an area at a time of the course."""


@dataclass(frozen=True)
class Snapshot:
    """What is to be known about one moment."""

    x_m: float
    y_m: float
    """Where it stands; without jumps where the world's period ends."""
    heading_rad: float
    retina: npt.NDArray[np.uint8] | None
    """What it saw last: (eyes, rays, channels)."""
    rays_m: Floats | None
    """How far each direction of its eye reaches until it meets something, NaN where that is not
    known: (directions,)."""
    contact: bool = False
    """Whether it met an obstacle on its way here."""
    put: bool = False
    """Whether it was put here from elsewhere."""


@dataclass(frozen=True)
class Eye:
    """Where rays go, as seen from the agent."""

    bearings_rad: Floats
    """(directions,)."""
    range_m: float
    left_m: float = 0.0
    """How far to the left of the agent's middle it sits."""


@dataclass(frozen=True)
class Course:
    """A course, at evenly spaced moments; at least one."""

    title: str
    period_s: float
    """From moment to moment."""
    snapshots: Sequence[Snapshot]
    eye: Eye
    bright: str
    """What a large value in a retina means."""
    scenery: Scenery
    radius_m: float = 0.0
    """Of the agent."""
    strip_m: tuple[float, float] | None = None
    """From which y to which the world extends; None: for ever."""
    lateral_period_m: float | None = None
    """How far to the left the same world begins anew; None: never."""

    @property
    def contacts(self) -> Sequence[int]:
        """Numbers of the moments at which contacts had begun."""
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
    """Whether the box around corners shares a place with an area."""
    (low_x, low_y), (high_x, high_y) = corners_m.min(axis=0), corners_m.max(axis=0)
    beside = low_x > area.high_x_m or high_x < area.low_x_m
    return not (beside or low_y > area.high_y_m or high_y < area.low_y_m)
