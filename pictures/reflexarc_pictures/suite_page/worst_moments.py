"""Finds the worst moments of a contender: where it scores least, what it saw coming for longest.

Of the cells that count, those with its least scores are driven again, in the first few of their
worlds. In each the contact is taken that had been straight ahead for the longest time: something
stood there, nearer by every step, and was run into all the same. That time is known where tracks
tell how far straight ahead is free; else, and among equals, the first contact is taken. A moment
that a second drive of the one agent alone does not show, as chance was part of it, is left out.
"""

import shlex
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from reflexarc_pictures.courses.world_course import drive_in_world
from reflexarc_pictures.suite_page.moment import Moment
from reflexarc_sim_bridge.evaluation.driving.drive import drive, extent_of
from reflexarc_sim_bridge.evaluation.metrics.track import Track
from reflexarc_sim_bridge.evaluation.protocol.contender import BLIND, Contender
from reflexarc_sim_bridge.evaluation.protocol.entrant import Entrant
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting, worlds_for
from reflexarc_sim_bridge.evaluation.protocol.suite import Suite, SuiteCell, SuiteFamily
from reflexarc_sim_bridge.evaluation.scoring.score_card import ScoreCard
from reflexarc_sim_bridge.worlds.seeds import test_seeds

MOMENTS = 5
LEAD_S = 3.0
"""How much of the drive before a contact is shown."""

_WORLDS, _LANES = 4, 4
"""Of each cell; a whole cell of a large suite would take long."""
_SHRINKS = 0.5
"""A time ahead that falls by one step, give or take this part of it, is that of one obstacle."""

Progress: TypeAlias = Callable[[int, int], None]


@dataclass(frozen=True)
class TrackContact:
    """One contact in a track."""

    agent: int
    step: int
    warning_steps: int


def worst_moments(
    entrant: Entrant,
    card: ScoreCard,
    suite: Suite,
    suite_name: str,
    progress: Progress = lambda done, of: None,
) -> list[Moment]:
    """At most `MOMENTS` of them, those of the least scores first, no two in one cell.

    Args:
        entrant: who drives again.
        card: its scores.
        suite: where it was measured.
        suite_name: name or file of the suite, as a command takes it.
        progress: called with the cells done and all that may be needed.

    Raises:
        ReflexarcError: it cannot be made, or cannot drive.
    """
    contender = entrant.contender()
    weakest = _weakest(card, suite)
    moments = list[Moment]()
    for number, (family, cell) in enumerate(weakest):
        progress(number, len(weakest))
        if len(moments) == MOMENTS:
            break
        command = _Command(entrant, card.setting, f"{suite_name}:{family.name}/{cell.tier}")
        moments += _moment(contender, family, cell, suite, command)
    progress(len(weakest), len(weakest))
    return moments


@dataclass(frozen=True)
class _Command:
    """The command line that draws a moment again, but for the moment."""

    entrant: Entrant
    setting: Setting
    target: str

    def at(self, seed: int, lane: int, from_s: float, seconds: float) -> str:
        """All of it."""
        words = ["reflexarc", "render", self.target]
        if self.entrant.source != BLIND:
            words += ["--policy", self.entrant.source]
        if self.entrant.rate_hz is not None:
            words += ["--rate", f"{self.entrant.rate_hz:g}"]
        words += ["--guard"] if self.entrant.is_guarded else []
        words += ["--setting", str(self.setting), "--seed", str(seed), "--lane", str(lane)]
        words += ["--from", f"{from_s:.6g}", "--seconds", f"{seconds:.6g}", "-o", "moment.png"]
        return shlex.join(words)


def _moment(
    contender: Contender, family: SuiteFamily, cell: SuiteCell, suite: Suite, command: _Command
) -> Iterator[Moment]:
    """The worst one of a cell; none where nothing was met, or not twice."""
    setting, some = command.setting, _some(suite)
    track = drive(contender, cell, some, setting)
    contact = worst_contact(track)
    if contact is None:
        return
    dt_s = track.circumstances.dt_s
    step = extent_of(track.circumstances, some).discarded + contact.step
    first = max(0, step + 1 - round(LEAD_S / dt_s))
    world, lane = divmod(contact.agent, some.lanes)
    seed = int(test_seeds(some.worlds)[world])
    from_s, seconds = first * dt_s, (step + 1 - first) * dt_s
    source = worlds_for(cell.source, contender, setting)
    course = drive_in_world(source, contender, seed, seconds, lane=lane, from_s=from_s)
    if not course.snapshots[-1].contact:
        return
    yield Moment(
        contender=contender.name,
        setting=setting,
        family=family.name,
        tier=cell.tier,
        world=source.drawn(seed).name,
        seed=seed,
        lane=lane,
        step=step,
        at_s=(step + 1) * dt_s,
        warning_s=contact.warning_steps * dt_s if np.isfinite(track.ahead_s).any() else None,
        course=course,
        command=command.at(seed, lane, from_s, seconds),
    )


def worst_contact(track: Track) -> TrackContact | None:
    """The contact that had been straight ahead for the longest time, among equals the first."""
    steps, agents = np.nonzero(track.met)
    if not len(steps):
        return None
    warned = _warnings(track)[steps, agents]
    k = int(np.argmax(warned))  # the first of the largest
    return TrackContact(int(agents[k]), int(steps[k]), int(warned[k]))


def _warnings(track: Track) -> npt.NDArray[np.int64]:
    """For how many steps, up to each, one obstacle was straight ahead: (steps, agents)."""
    dt_s = track.circumstances.dt_s
    lasting = np.zeros(track.met.shape, np.int64)
    for step in range(1, track.steps):
        before, now = track.ahead_s[step - 1], track.ahead_s[step]
        with np.errstate(invalid="ignore"):
            is_same = np.abs(before - now - dt_s) <= _SHRINKS * dt_s
        is_same &= ~track.met[step - 1]
        lasting[step] = np.where(is_same, lasting[step - 1] + 1, 0)
    return lasting


def _weakest(card: ScoreCard, suite: Suite) -> Sequence[tuple[SuiteFamily, SuiteCell]]:
    """Cells that count, that with the least score first."""
    by_name = {(family.name, cell.tier): (family, cell) for family, cell in suite.cells}
    cells = [cell for cells in card.cells.values() for cell in cells]
    told = [
        cell
        for cell in cells
        if cell.counts and np.isfinite(cell.score.value) and (cell.family, cell.tier) in by_name
    ]
    ordered = sorted(told, key=lambda cell: cell.score.value)
    return [by_name[key] for key in dict.fromkeys((each.family, each.tier) for each in ordered)]


def _some(suite: Suite) -> Suite:
    return replace(suite, worlds=min(suite.worlds, _WORLDS), lanes=min(suite.lanes, _LANES))
