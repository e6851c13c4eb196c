"""The omniscient oracle: the fewest contacts that any policy can expect with a body and its rate.

It knows all that stands in a world, and how it will move. Its figure is exact for a body that obeys
at once and exactly, on the lattice of that body's own motions (`rows.py`, `least_contacts.py`): the
least expectation over all policies, from a place at which a drive begins, drawn evenly. Contacts
before the counting begins cost it nothing, so no policy has fewer in what is counted.

What it leaves out makes it abler than any body, never less able: lag, slip, latency and noise; and
after a contact it goes on at the end of the step, not where it touched. A body at 50 Hz can do all
that one at 10 Hz can, and more: it has an oracle of its own rate.

A body that may also stand or go slower, such as one behind a guard, is no body of this oracle.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.motion import Action
from reflexarc_sim_bridge.evaluation.driving.drive import Extent, circumstances_of, extent_of
from reflexarc_sim_bridge.evaluation.limits.kept import kept
from reflexarc_sim_bridge.evaluation.limits.least_contacts import go_back
from reflexarc_sim_bridge.evaluation.limits.rows import Rows, bare, blocks_back, rows_of
from reflexarc_sim_bridge.evaluation.metrics.sums import Sums
from reflexarc_sim_bridge.evaluation.metrics.track import Floats
from reflexarc_sim_bridge.evaluation.protocol.contender import Contender
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting, worlds_for
from reflexarc_sim_bridge.evaluation.protocol.suite import Suite, SuiteCell
from reflexarc_sim_bridge.native.cache import prepare
from reflexarc_sim_bridge.worlds.seeds import test_seeds
from reflexarc_sim_bridge.worlds.world import World

ORACLE = "oracle"
"""Its name among contenders."""


class Values(NamedTuple):
    """Contacts to expect from the rows of a lattice."""

    least: Floats
    """From each row; infinity where one cannot stand: (rows,)."""
    anew: Floats
    """From where one is put beside each row, drawn evenly: (rows,)."""


class OracleQuestion(NamedTuple):
    """A question to the oracle."""

    worlds: list[tuple[World, int]]
    """Bare worlds and their seeds."""
    actions: tuple[Action, ...]
    extent: Extent

    @property
    def text(self) -> str:
        """All that the answer depends on, in words: of a world, what can be met, and when."""
        fields = "layers", "edges", "width_m", "dt_s", "stream"
        worlds = [
            (*(getattr(world, name) for name in fields), world.chassis.radius_m, seed)
            for world, seed in self.worlds
        ]
        speeds = [(each.linear_mps, each.lateral_mps) for each in self.actions]
        return repr((worlds, speeds, tuple(self.extent.__dict__.values())))


def oracle_sums(
    contender: Contender,
    cell: SuiteCell,
    suite: Suite,
    setting: Setting,
    seeds: npt.NDArray[np.uint64] | None = None,
) -> Sums:
    """What an oracle would have done in a contender's place: as `sums_of` its track.

    Contacts are expectations, and no whole numbers.

    Args:
        contender: whose speeds, rate and body.
        cell: where.
        suite: how much of it.
        setting: at which rate, with which body.
        seeds: of the worlds, (suite.worlds,); None: the test seeds.

    Raises:
        UsageError: no oracle is known for such a body, or in such a world.
    """
    asked = depends_on(contender, cell, suite, setting, seeds)
    worlds, extent = asked.worlds, asked.extent
    least = kept(
        asked.text,
        lambda: [least_contacts(*world, contender.contract, extent) for world in worlds],
    )
    time_s = np.full(len(worlds), suite.lanes * extent.counted * worlds[0][0].dt_s)
    return {
        "contacts": suite.lanes * np.array(least),
        "progress_m": contender.contract.actions[0].linear_mps * time_s,
        "time_s": time_s,
    }


def depends_on(
    contender: Contender,
    cell: SuiteCell,
    suite: Suite,
    setting: Setting,
    seeds: npt.NDArray[np.uint64] | None = None,
) -> OracleQuestion:
    """All that the oracle's figures of a cell depend on: see `oracle_sums`."""
    source = worlds_for(cell.source, contender, setting)
    seeds = test_seeds(suite.worlds) if seeds is None else seeds
    circumstances = circumstances_of(source, contender.contract, cell)
    worlds = [(bare(source.drawn(seed)), seed) for seed in seeds.tolist()]
    return OracleQuestion(worlds, contender.contract.actions, extent_of(circumstances, suite))


def least_contacts(world: World, seed: int, contract: PolicyContract, extent: Extent) -> float:
    """Fewest contacts to expect in the counted steps of a world, from a start drawn evenly.

    Raises:
        UsageError: see `oracle_sums`.
    """
    values = values_at_start(world, seed, rows_of(world, contract, _steps(extent)), extent)
    return float(values.anew[len(values.anew) // 2])


def values_at_start(world: World, seed: int, rows: Rows, extent: Extent) -> Values:
    """Fewest contacts to expect from each row, when a drive begins.

    Args:
        world: a bare one.
        seed: which of its variants.
        rows: the body's lattice.
        extent: how many steps it goes.
    """
    prepare()
    count = len(rows.rows_m)
    values, anew, scratch = np.zeros(count), np.zeros(count), np.empty((2, count + 1))
    for first, found in blocks_back(world, seed, rows, _steps(extent)):
        uncounted = max(0, extent.discarded - first)
        form = rows.shifts, rows.wraps, rows.window, uncounted
        go_back(found, *form, values, anew, scratch)
    return Values(values, anew)


def _steps(extent: Extent) -> int:
    return extent.discarded + extent.counted
