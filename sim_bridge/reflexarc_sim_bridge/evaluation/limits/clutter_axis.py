"""Contacts over clutter between the two limits, and the clutter at which no way leads through.

Clutter is ρR²v/w. In a Poisson forest there is a critical clutter: below it there is a way through
that never ends, above it every way does, whoever plans it (Karaman and Frazzoli, "High-speed
flight in an ergodic forest", arXiv 1202.0253). They prove that there is one; where it lies
is found here by trial: in how many worlds a way leads through a long stretch. In a stretch that is
neither endless nor endlessly wide the change is gradual; half of the worlds mark it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.motion import sideways_actions
from reflexarc_sim_bridge.evaluation.driving.drive import Extent, drive
from reflexarc_sim_bridge.evaluation.limits.oracle import oracle_sums, values_at_start
from reflexarc_sim_bridge.evaluation.limits.rows import bare, rows_of
from reflexarc_sim_bridge.evaluation.metrics.sums import Sums, sums_of
from reflexarc_sim_bridge.evaluation.protocol.contender import BLIND, Contender
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import Suite, SuiteCell
from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy
from reflexarc_sim_bridge.worlds.layers import Scatter
from reflexarc_sim_bridge.worlds.seeds import test_seeds
from reflexarc_sim_bridge.worlds.shapes import Discs
from reflexarc_sim_bridge.worlds.world import World

CLUTTERS = (0.02, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5)
SIDEWAYS = (0.25, 0.5, 1.0)
"""w/v."""

_WORLD = "reference-1"
_TREE_M = 0.45
"""Radius of a tree: R of the reference field."""


@dataclass(frozen=True)
class ClutterPoint:
    """The limits at one degree of clutter."""

    clutter: float
    sideways: float
    """w/v."""
    blind_per_100m: float
    oracle_per_100m: float


def clutter_curve(
    suite: Suite, sideways: float, clutters: Sequence[float] = CLUTTERS
) -> list[ClutterPoint]:
    """Both limits over clutter, in the reference field's obstacles.

    Args:
        suite: how many worlds, and how much of each.
        sideways: w/v.
        clutters: ρR²v/w, each.
    """
    contract = PolicyContract(actions=sideways_actions(1.0, sideways))
    blind = Contender(BLIND, BlindPolicy(), contract)
    points = []
    for clutter in clutters:
        cell = SuiteCell(f"{clutter:.2f}", _WORLD, clutter=clutter * sideways)
        rates = (
            _per_100m(sums_of(drive(blind, cell, suite, Setting.FIELD))),
            _per_100m(oracle_sums(blind, cell, suite, Setting.FIELD)),
        )
        points.append(ClutterPoint(clutter, sideways, *rates))
    return points


def share_passed(
    clutter: float, sideways: float, width_m: float, length_m: float, rate_hz: float, worlds: int
) -> float:
    """In how many forests some way leads through without a contact, as a share.

    Args:
        clutter: ρR²v/w.
        sideways: w/v, of a point that goes 1 m/s ahead.
        width_m: period across.
        length_m: of the stretch.
        rate_hz: decisions a second.
        worlds: how many.
    """
    world = bare(_forest(clutter * sideways, width_m, 1.0 / rate_hz))
    contract = PolicyContract(actions=sideways_actions(1.0, sideways))
    steps = round(length_m * rate_hz)
    seeds = test_seeds(worlds).tolist()
    return float(np.mean([_has_way(world, seed, contract, steps) for seed in seeds]))


def critical_clutter(
    clutters: Sequence[float],
    sideways: float,
    width_m: float = 40.0,
    length_m: float = 100.0,
    rate_hz: float = 20.0,
    worlds: int = 32,
) -> tuple[float, float]:
    """Between which two degrees of clutter half of the worlds become blocked.

    Args:
        clutters: growing; others as of `share_passed`.
        sideways: the same.
        width_m: the same.
        length_m: the same.
        rate_hz: the same.
        worlds: the same.

    Returns:
        The last one at which at least half of them can be passed (0: none), and the next one
        (infinity: there is none).
    """
    passed = 0.0
    for clutter in clutters:
        if share_passed(clutter, sideways, width_m, length_m, rate_hz, worlds) < 0.5:
            return passed, clutter
        passed = clutter
    return passed, float("inf")


def _has_way(world: World, seed: int, contract: PolicyContract, steps: int) -> bool:
    rows = rows_of(world, contract, steps)
    values = values_at_start(world, seed, rows, Extent(0, steps))
    return bool((values.least == 0.0).any())


def _forest(density_r2: float, width_m: float, dt_s: float) -> World:
    """Trees as in the theory: discs of one size, anywhere; ρR² is given."""
    trees = (Discs(radius_m=(_TREE_M, _TREE_M)),)
    layer = Scatter(density_per_m2=density_r2 / _TREE_M**2, shapes=trees)
    return World("forest", width_m=width_m, dt_s=dt_s, layers=(layer,))


def _per_100m(sums: Sums) -> float:
    return 100.0 * float(sums["contacts"].sum() / sums["progress_m"].sum())
