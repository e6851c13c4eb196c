"""A course: the path of an agent with what it saw and touched, in snapshots at equal intervals.

Films and pictures of drives are made of it.

Frame: x ahead to the right of a picture, y to the left upwards, metres.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from reflexarc_pictures.log_pictures.logged_poses import Floats
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_sim_bridge.worlds.silhouettes import Area, Silhouette


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
