"""Two contenders through the same worlds, from the same places, until someone has seen enough.

Where both do the same, nothing tells them apart: the same file against itself makes the same
contacts. Validation worlds, for whoever compares often would wear out the test worlds.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from reflexarc_sim_bridge.evaluation.driving.drive import DISCARDED_M, circumstances_of, start
from reflexarc_sim_bridge.evaluation.driving.reach import Reach
from reflexarc_sim_bridge.evaluation.metrics.track import Floats
from reflexarc_sim_bridge.evaluation.protocol.contender import Contender
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting, worlds_for
from reflexarc_sim_bridge.evaluation.protocol.suite import SuiteCell
from reflexarc_sim_bridge.worlds.seeds import validation_seeds

PAIRED_WORLDS = 1000
"""All validation worlds."""
FIRST_LOOK_M = 40.0
"""Way of each agent before the first look; each later look has twice as much behind it."""
LOOKS = 5
MOST_M = FIRST_LOOK_M * 2 ** (LOOKS - 1)
MOST_TRIALS = 2 ** (LOOKS - 1)
TRIAL_S = 60.0
"""For how long a body that turns is watched."""


@dataclass(frozen=True)
class Pair:
    """What two contenders did so far, world by world, the less the better: (worlds,) each.

    Contacts; of bodies that turn, how far the other one came, so that here, too, new / old above 1
    is a loss.
    """

    new: Floats
    old: Floats


def drive_pair(
    new: Contender,
    old: Contender,
    cells: tuple[SuiteCell, ...],
    setting: Setting,
    is_enough: Callable[[Pair], bool],
    worlds: int = PAIRED_WORLDS,
    lane: int = 0,
) -> None:
    """Drive both through the cells of a family, and show what they did after each look's way.

    Args:
        new: who is judged.
        old: whom it is compared with; it turns if the new one does.
        cells: where; the ways in all of them are equally long.
        setting: at which rate, with which body.
        is_enough: asked at each look; ends the drive.
        worlds: how many validation worlds.
        lane: where in them they begin.
    """
    kind = _Trials if new.turns else _Way
    sides = [[kind(who, cell, setting, worlds, lane) for cell in cells] for who in (new, old)]
    for look in range(LOOKS):
        for side in (*sides[0], *sides[1]):
            side.go_on(2**look - (2 ** (look - 1) if look else 0))
        of_new, of_old = (np.sum([each.sums for each in side], axis=0) for side in sides)
        if is_enough(Pair(of_old, of_new) if new.turns else Pair(of_new, of_old)):
            return


class _Side(Protocol):
    """One contender in one cell."""

    sums: Floats

    def go_on(self, units: int) -> None: ...


class _Way(_Side):
    """Contacts of a body that moves sideways; a unit is `FIRST_LOOK_M`."""

    def __init__(
        self, who: Contender, cell: SuiteCell, setting: Setting, worlds: int, lane: int
    ) -> None:
        driven = worlds_for(cell.source, who, setting)
        circumstances = circumstances_of(driven, who.contract, cell)
        self._simulation, self._driver = start(
            driven, who, validation_seeds(worlds), np.full(worlds, lane, np.uint64)
        )
        self._step_m = circumstances.forward_mps * circumstances.dt_s
        self.sums: Floats = np.zeros(worlds)
        self._drive(DISCARDED_M)
        self.sums[:] = 0.0

    def go_on(self, units: int) -> None:
        self._drive(units * FIRST_LOOK_M)

    def _drive(self, way_m: float) -> None:
        for _ in range(round(way_m / self._step_m)):
            self._simulation.sense()
            met = self._simulation.step(self._driver.drive(self._simulation))
            self.sums += met
            self._driver.begin_anew(met)


class _Trials(_Side):
    """How far a body that turns comes before its first contact; a unit is one trial an agent."""

    def __init__(
        self, who: Contender, cell: SuiteCell, setting: Setting, worlds: int, lane: int
    ) -> None:
        self._who, self._seeds = who, validation_seeds(worlds)
        self._driven = worlds_for(cell.source, who, setting)
        self._trials, self._lane = 0, lane * MOST_TRIALS
        self.sums: Floats = np.zeros(worlds)

    def go_on(self, units: int) -> None:
        for _ in range(units):
            lanes = np.full(len(self._seeds), self._lane + self._trials, np.uint64)
            simulation, driver = start(self._driven, self._who, self._seeds, lanes)
            reach = Reach(simulation)
            for _step in range(round(TRIAL_S / simulation.dt_s)):
                simulation.sense()
                reach.note(simulation.step(driver.drive(simulation)))
            self.sums += reach.greatest_m
            self._trials += 1
