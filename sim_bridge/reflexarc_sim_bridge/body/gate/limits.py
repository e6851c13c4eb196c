"""How a body keeps within its own limits: two pure functions on its motion.

Too fast a command is scaled as a whole, so that the robot goes the way that it was told, slower.
A speed grows by no more than acceleration · time, on each axis by itself; it falls at once, because
no limit may delay a stop.
"""

from dataclasses import dataclass
from typing import Protocol

from reflexarc_runtime.contract.body_limits import BodyLimits


class Twist(Protocol):
    """Anything with three speeds: an action of a contract, a command, a motion."""

    @property
    def linear_mps(self) -> float:
        """Speed ahead."""

    @property
    def lateral_mps(self) -> float:
        """Speed to the left."""

    @property
    def angular_radps(self) -> float:
        """Angular speed, counter-clockwise."""


@dataclass(frozen=True, slots=True)
class Motion:
    """What a body does now, in its own frame."""

    linear_mps: float = 0.0
    lateral_mps: float = 0.0
    angular_radps: float = 0.0

    @property
    def stands(self) -> bool:
        """Whether all three speeds are 0."""
        return self.linear_mps == self.lateral_mps == self.angular_radps == 0.0


STANDSTILL = Motion()


def slowed(twist: Twist, limits: BodyLimits) -> tuple[Motion, bool]:
    """A twist within the limits of speed, in the same direction, and whether it was too fast.

    Args:
        twist: three finite speeds.
        limits: of the body; a speed whose limit is 0 makes the whole twist a standstill.
    """
    linear, lateral, angular = twist.linear_mps, twist.lateral_mps, twist.angular_radps
    share = min(
        _share(linear, limits.linear_mps),
        _share(lateral, limits.lateral_mps),
        _share(angular, limits.angular_radps),
    )
    if share >= 1.0:
        return Motion(linear, lateral, angular), False
    return Motion(
        _within(linear * share, limits.linear_mps),
        _within(lateral * share, limits.lateral_mps),
        _within(angular * share, limits.angular_radps),
    ), True


def eased(before: Motion, wanted: Motion, acceleration_mps2: float, dt_s: float) -> Motion:
    """The motion after a time, on the way from one to another; standstill is reached at once.

    Args:
        before: what the body did.
        wanted: what it shall do.
        acceleration_mps2: most that a speed grows in a second.
        dt_s: the time, seconds; none if it is not above 0.
    """
    if acceleration_mps2 == float("inf"):
        return wanted
    gain_mps = acceleration_mps2 * dt_s if dt_s > 0.0 else 0.0
    return Motion(
        _eased(before.linear_mps, wanted.linear_mps, gain_mps),
        _eased(before.lateral_mps, wanted.lateral_mps, gain_mps),
        wanted.angular_radps,
    )


def _share(speed: float, limit: float) -> float:
    return limit / abs(speed) if abs(speed) > limit else 1.0


def _within(speed: float, limit: float) -> float:
    """The product of a speed and a rounded share may be one step beyond the limit."""
    return max(-limit, min(limit, speed))


def _eased(before: float, wanted: float, gain: float) -> float:
    # What goes the other way has stopped first, at once: it begins at 0.
    begin = abs(before) if before * wanted > 0.0 else 0.0
    most = begin + gain
    return max(-most, min(most, wanted))
