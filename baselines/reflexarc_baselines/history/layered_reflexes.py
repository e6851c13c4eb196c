"""Layered reflexes: a behaviour is a set of primitive reflexes that act at once and are summed.

Source: T. L. Anderson and M. Donath, *Animal behavior as a paradigm for developing robot autonomy*,
Robotics and Autonomous Systems 6, 1990. Only its abstract could be read: the primitives and the
sets are its own, as cited by others; the equations are ours.

    passive avoid   −Σ û δφ / d over the rays that meet something
    active avoid    from the nearest ray within 45° of ahead, straight to the other side, with 1/d
    open space      to the farthest ray; of equal ones the one nearest to ahead
    forward         (1, 0)
    perimeter       to the nearest ray, turned 45° towards ahead (but not past it): along what is
                    near, and to it
    stop            at a contact: nothing at uniform speed, and not built

    wander = {passive avoid, active avoid, forward},   perimeter = {passive avoid, perimeter}

A long straight wall abeam at d pushes aside with ∫ sin²φ / d dφ over the quarter turn ahead of it,
π/4d. So perimeter's pull k sin 45° = π/4D holds the body at the distance D. T is the direction of
the sum, each term times its gain.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from math import pi, sqrt
from typing import ClassVar

import numpy as np

from reflexarc_baselines.baseline import Fidelity, Floats, Origin, Sees, Span
from reflexarc_baselines.history.vectors import Vectors, pointing, pulled
from reflexarc_baselines.picking import picked
from reflexarc_baselines.rays import bearings_rad, distances_m
from reflexarc_baselines.steering import steer
from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.sensing.ray_values import FULL_SCALE
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract

_AHEAD_RAD = pi / 4.0
"""What active avoid takes for ahead, and by how much perimeter looks along."""


class Primitive(StrEnum):
    """A reflex."""

    PASSIVE_AVOID = "passive_avoid"
    ACTIVE_AVOID = "active_avoid"
    OPEN_SPACE = "open_space"
    FORWARD = "forward"
    PERIMETER = "perimeter"


def _origin(remarks: str) -> Origin:
    source = (
        "T. L. Anderson and M. Donath, Animal behavior as a paradigm for developing robot "
        "autonomy, Robotics and Autonomous Systems 6, 1990"
    )
    return Origin(source, Fidelity.RECONSTRUCTED, Sees.RANGES, remarks=remarks)


@dataclass(frozen=True)
class _LayeredReflexes:
    """The primitives; which of them act, a set says."""

    primitives: tuple[Primitive, ...] = ()
    """Those that act."""
    passive_gain: float = 1.0
    active_gain: float = 1.0
    open_gain: float = 1.0
    keeps_m: float = 1.0
    """D: the distance at which perimeter holds the body from a long wall."""
    dead_band_rad: float = 0.1
    """Direction of the sum below which the body stays on its way."""
    drives_by: PolicyContract = field(default_factory=reference_contract)
    """Its eye and its motions."""

    @property
    def contract(self) -> PolicyContract:
        """The reference field's eye and motions."""
        return self.drives_by

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        """See `Policy`."""
        ranges_m = distances_m(retinas, self.drives_by.retina)
        return steer(self.wish(ranges_m).headings_rad, self.dead_band_rad)

    def wish(self, ranges_m: Floats) -> Vectors:
        """The sum of the primitives that act, of distances (n, rays)."""
        nothing = np.zeros(len(ranges_m), np.float32)
        return sum(
            (self.term(name, ranges_m) for name in self.primitives), Vectors(nothing, nothing)
        )

    def term(self, primitive: Primitive, ranges_m: Floats) -> Vectors:
        """What one primitive adds."""
        match primitive:
            case Primitive.PASSIVE_AVOID:
                return self._passive_avoid(ranges_m).times(self.passive_gain)
            case Primitive.ACTIVE_AVOID:
                return self._active_avoid(ranges_m).times(self.active_gain)
            case Primitive.OPEN_SPACE:
                return self._open_space(ranges_m).times(self.open_gain)
            case Primitive.FORWARD:
                return pointing(np.zeros(len(ranges_m), np.float32))
            case Primitive.PERIMETER:
                return self._perimeter(ranges_m).times(pi / (4.0 * self.keeps_m) * sqrt(2.0))

    @property
    def _bearings_rad(self) -> Floats:
        return bearings_rad(self.drives_by.retina)

    def _nearness(self, ranges_m: Floats) -> Floats:
        """1/d of the rays that meet something, else 0; never beyond one step of a retina."""
        range_m = self.drives_by.retina.range_m
        near_m = np.maximum(ranges_m, np.float32(range_m / FULL_SCALE))
        return np.where(ranges_m < range_m, np.float32(1.0) / near_m, np.float32(0.0))

    def _nearest_rad(self, ranges_m: Floats) -> Floats:
        """The bearing of the nearest ray; of equal ones the leftmost."""
        return picked(self._bearings_rad, ranges_m.argmin(axis=1))

    def _passive_avoid(self, ranges_m: Floats) -> Vectors:
        eye = self.drives_by.retina
        return pulled(
            self._nearness(ranges_m) * np.float32(-eye.fov_rad / eye.rays), self._bearings_rad
        )

    def _active_avoid(self, ranges_m: Floats) -> Vectors:
        is_ahead = np.abs(self._bearings_rad) <= _AHEAD_RAD
        ahead_m = np.where(is_ahead, ranges_m, np.float32(self.drives_by.retina.range_m))
        nearness = self._nearness(ahead_m)
        side = np.where(self._nearest_rad(ahead_m) > 0.0, -1.0, 1.0)
        left = (side * nearness.max(axis=1)).astype(np.float32)
        return Vectors(np.zeros_like(left), left)

    def _open_space(self, ranges_m: Floats) -> Vectors:
        outwards = np.argsort(np.abs(self._bearings_rad), kind="stable")
        farthest = ranges_m[:, outwards].argmax(axis=1)
        return pointing(picked(self._bearings_rad[outwards], farthest))

    def _perimeter(self, ranges_m: Floats) -> Vectors:
        nearness = self._nearness(ranges_m)
        nearest_rad = self._nearest_rad(ranges_m)
        along_rad = np.sign(nearest_rad) * np.maximum(np.abs(nearest_rad) - _AHEAD_RAD, 0.0)
        return pointing(along_rad.astype(np.float32)).times(nearness.max(axis=1) > 0.0)


@dataclass(frozen=True)
class LayeredWander(_LayeredReflexes):
    """Goes forward, away from what is near."""

    ORIGIN: ClassVar[Origin] = _origin("the set wander")
    SEARCHED: ClassVar[Mapping[str, Span]] = {
        "passive_gain": Span(0.1, 10.0, is_log=True),
        "active_gain": Span(0.01, 10.0, is_log=True),
        "dead_band_rad": Span(0.01, 0.8, is_log=True),
    }

    primitives: tuple[Primitive, ...] = (
        Primitive.PASSIVE_AVOID,
        Primitive.ACTIVE_AVOID,
        Primitive.FORWARD,
    )
    passive_gain: float = 0.405
    active_gain: float = 0.0132
    dead_band_rad: float = 0.0292


@dataclass(frozen=True)
class LayeredPerimeter(_LayeredReflexes):
    """Goes along what is near, at a distance."""

    ORIGIN: ClassVar[Origin] = _origin("the set perimeter")
    SEARCHED: ClassVar[Mapping[str, Span]] = {
        "keeps_m": Span(0.3, 5.0),
        "dead_band_rad": Span(0.01, 0.8, is_log=True),
    }

    primitives: tuple[Primitive, ...] = (Primitive.PASSIVE_AVOID, Primitive.PERIMETER)
    keeps_m: float = 3.13
    dead_band_rad: float = 0.218
