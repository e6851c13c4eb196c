"""Steering by pairs of motion detectors, mirrored left and right: the common part of two systems.

    μ ← μ + (1 − β_μ)(I − μ),   s = I − μ          what each ray sees, less its own slow mean
    m = s̄_a s_b − s_a s̄_b                          `correlators.py`; a lies inside, b outside
    T = Σ_k w_k (g(m_right,k) − g(m_left,k)),   g(m) = m / (κ + |m|)

What comes nearer moves outward on the retina, so a positive weight turns away from it. A body that
sidesteps as fast as it drives sees mostly its own motion, and what it passes moves outward too:
evolution found negative weights for most detectors, for a reason that was not looked into. Without
the slow mean a correlator follows brightness. All filters are linear: they run on the rays, and the
receptors are taken from the filtered rays.

All functions are for many genomes at once: axis 0 is the genome, axis 1 the agents that live by it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from reflexarc_baselines.baseline import Floats
from reflexarc_baselines.correlators import kept_share, low_passed, motion, receptors
from reflexarc_runtime.arrays import Memories
from reflexarc_runtime.config.checks import require
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.contract.state_spec import StateSpec
from reflexarc_runtime.errors import UsageError


@dataclass(frozen=True)
class Detectors:
    """What evolution found: mirror pairs of motion detectors, and what they share."""

    bearings_rad: tuple[float, ...]
    """Of each pair: the middle of its receptors, to either side of straight ahead."""
    separations_rad: tuple[float, ...]
    """Between the two receptors of a detector."""
    weights: tuple[float, ...]
    """w_k."""
    tau_s: float
    """τ of a detector's late arm."""
    mean_s: float
    """Time constant of the slow mean that is taken off."""
    dead_band: float
    """|T| below which it stays on its way."""
    saturation: float
    """κ: a response of this size counts half."""

    def __post_init__(self) -> None:
        pairs = {len(self.bearings_rad), len(self.separations_rad), len(self.weights)}
        require(len(pairs) == 1, "detectors", "as many of each list", pairs, UsageError)
        for name in ("tau_s", "mean_s", "saturation"):
            value = getattr(self, name)
            require(0.0 < value < float("inf"), f"detectors.{name}", "positive", value, UsageError)


class Wiring(NamedTuple):
    """Many sets of detectors as arrays; axis 0 is the set."""

    receptors: Floats
    """From rays to the inner and outer receptors on the right, then on the left: (g, rays, 4k)."""
    weights: Floats
    """(g, 1, k)."""
    kept: Floats
    """β: (g, 1, 1)."""
    kept_mean: Floats
    """β_μ: (g, 1, 1)."""
    saturation: Floats
    """κ: (g, 1, 1)."""
    dead_band: Floats
    """(g, 1)."""


def wired(sets: Sequence[Detectors], eye: RetinaSpec, period_s: float) -> Wiring:
    """The sets as arrays, for one eye and one time between two decisions."""
    one_each = (len(sets), 1, 1)
    kept = [kept_share(period_s, each.tau_s) for each in sets]
    kept_mean = [kept_share(period_s, each.mean_s) for each in sets]
    return Wiring(
        receptors=receptors(eye, np.array([_looks_rad(each) for each in sets])),
        weights=np.array([each.weights for each in sets], np.float32)[:, np.newaxis],
        kept=np.array(kept, np.float32).reshape(one_each),
        kept_mean=np.array(kept_mean, np.float32).reshape(one_each),
        saturation=np.array([each.saturation for each in sets], np.float32).reshape(one_each),
        dead_band=np.array([each.dead_band for each in sets], np.float32)[:, np.newaxis],
    )


def memory_of(eye: RetinaSpec) -> StateSpec:
    """Each ray's slow mean, its late signal, and whether anything has been seen yet."""
    return StateSpec(size=2 * eye.rays + 1)


def wish(wiring: Wiring, rays: Floats, memories: Memories) -> tuple[Floats, Memories]:
    """T of each agent, and what it remembers; at its first look it only remembers.

    Args:
        wiring: of g sets of detectors.
        rays: brightness, 0 to 1: (g, n, rays).
        memories: (g, n, 2 rays + 1), see `memory_of`.
    """
    count = rays.shape[-1]
    mean, late, has_seen = np.split(memories, (count, 2 * count), axis=-1)
    mean = np.where(has_seen > 0.0, low_passed(mean, rays, wiring.kept_mean), rays)
    signal: Floats = rays - mean
    late = low_passed(late, signal, wiring.kept)
    following = np.concatenate([mean, late, np.ones_like(has_seen)], axis=-1)
    return _summed(wiring, signal, late), following


def _summed(wiring: Wiring, signal: Floats, late: Floats) -> Floats:
    now, before = signal @ wiring.receptors, late @ wiring.receptors
    (in_right, out_right, in_left, out_left) = np.split(now, 4, axis=-1)
    (late_in_right, late_out_right, late_in_left, late_out_left) = np.split(before, 4, axis=-1)
    right = motion(in_right, late_in_right, out_right, late_out_right)
    left = motion(in_left, late_in_left, out_left, late_out_left)
    pulls = _saturated(right, wiring.saturation) - _saturated(left, wiring.saturation)
    total: Floats = (wiring.weights * pulls).sum(axis=-1)
    return total


def _saturated(response: Floats, half: Floats) -> Floats:
    """See the formula of the module for g."""
    return response / (half + np.abs(response))


def _looks_rad(detectors: Detectors) -> list[float]:
    """Where the receptors look, in the order of `Wiring.receptors`."""
    pairs = list(zip(detectors.bearings_rad, detectors.separations_rad, strict=True))
    inner = [bearing - apart / 2.0 for bearing, apart in pairs]
    outer = [bearing + apart / 2.0 for bearing, apart in pairs]
    return [*(-look for look in inner), *(-look for look in outer), *inner, *outer]
