"""Wheels with inertia: how far a robot rolls by the twists that it was told.

Its speed approaches the last twist's by at most `braking_mps2`; after `timeout_s` without a twist
the wanted speed is zero, as `cmd_vel_timeout` of diff_drive_controller does it, or never. It is
computed afterwards from what the robot heard, in steps of 1 ms: nothing disturbs it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from support.ros2_robot import Told

STEP_NS = 1_000_000


@dataclass(frozen=True)
class Base:
    """The wheels of a robot."""

    braking_mps2: float = 2.0
    timeout_s: float = math.inf
    """How long a twist holds; for ever by default."""


HOLDS_FOR_EVER = Base()
WITH_TIMEOUT = Base(timeout_s=0.5)
"""cmd_vel_timeout of diff_drive_controller by default."""


@dataclass(frozen=True)
class Roll:
    """How a robot came to a standstill."""

    standstill_s: float
    """After the moment that is asked about; infinite: it never stood to the end."""
    distance_m: float
    """From that moment on."""


def rolled(base: Base, told: Sequence[Told], since_ns: int, until_ns: int) -> Roll:
    """The motion of a base between two moments of the wall clock."""
    speed_mps = next((w.ahead_mps for w in reversed(told) if w.arrived_ns <= since_ns), 0.0)
    distance_m, stood_ns, heard = 0.0, None, 0
    for now_ns in range(since_ns, until_ns, STEP_NS):
        while heard < len(told) and told[heard].arrived_ns <= now_ns:
            heard += 1
        wanted_mps = _wanted_mps(base, told[heard - 1] if heard else None, now_ns)
        most_mps = base.braking_mps2 * STEP_NS * 1e-9
        speed_mps += max(-most_mps, min(most_mps, wanted_mps - speed_mps))
        distance_m += abs(speed_mps) * STEP_NS * 1e-9
        if speed_mps != 0.0:
            stood_ns = None
        elif stood_ns is None:
            stood_ns = now_ns
    standstill_s = math.inf if stood_ns is None else (stood_ns - since_ns) * 1e-9
    return Roll(standstill_s, distance_m)


def _wanted_mps(base: Base, word: Told | None, now_ns: int) -> float:
    if word is None or (now_ns - word.arrived_ns) * 1e-9 > base.timeout_s:
        return 0.0
    return word.ahead_mps
