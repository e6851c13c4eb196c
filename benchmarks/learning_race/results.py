"""Results of a contender over its seeds.

A time is that of the first of two looks in a row that pass a level; for a seed that does not reach
it, the length of the run is taken. If fewer than 8 of 10 seeds reach a level, its time is censored:
only a lower bound is known. All else are interquartile means with 95 % bootstrap intervals.
"""

from dataclasses import dataclass
from pathlib import Path

from learning_race.contenders import CONTENDERS, Contender
from learning_race.judge import LEVELS, Look, reached
from learning_race.record import read_record
from reflexarc_sim_bridge.evaluation.scoring.statistics import Estimate, estimate

LEAST_SHARE = 0.8
"""Share of the seeds that must reach a level."""


@dataclass(frozen=True)
class Run:
    """One run, as recorded in its file."""

    contender: str
    settings: str
    seed: int
    budget_s: float
    seconds: float
    """Time of learning."""
    looks: list[Look]
    test: list[float] | None = None
    """Contacts per 100 m on test worlds, and the ends of its interval; None for a cold run."""
    undisturbed_s: float | None = None
    """Time to the first level without looks; None if it was not measured."""


@dataclass(frozen=True)
class Reached:
    """When the seeds of a contender reached a level."""

    seconds: list[float]
    """Time of every seed; the length of the run if it did not reach the level."""
    world_steps: list[float]
    seeds: int
    """Number of seeds that reached the level."""

    @property
    def is_censored(self) -> bool:
        """Whether too few seeds reached it."""
        return self.seeds < LEAST_SHARE * len(self.seconds)

    @property
    def time_s(self) -> Estimate:
        """Interquartile mean of the times, with its interval."""
        return estimate(self.seconds)


def read_runs(out: Path, *, cold: bool = False) -> dict[str, list[Run]]:
    """The runs of each contender, in the order of the contenders."""
    runs: dict[str, list[Run]] = {}
    for contender in CONTENDERS:
        found = sorted(out.glob(f"{contender.name}-[0-9]*.json"))
        mine = [_read(path) for path in found if path.stem.endswith("-cold") == cold]
        mine = [run for run in mine if run.contender == contender.name]
        if mine:
            runs[contender.name] = mine
    return runs


def group_of(name: str) -> str:
    """The group of a contender."""
    return _contender(name).group


def times_to(runs: list[Run], level: float) -> Reached:
    """Times and world steps to a level."""
    looks = [reached(run.looks, level) for run in runs]
    unreached = [Look(run.seconds, run.looks[-1].world_steps, 0.0) for run in runs]
    ends = [look or end for look, end in zip(looks, unreached, strict=True)]
    count = sum(look is not None for look in looks)
    seconds, steps = [end.seconds for end in ends], [float(end.world_steps) for end in ends]
    return Reached(seconds, steps, count)


def undisturbed(runs: list[Run]) -> Reached:
    """Times to the first level without looks, for the runs that were timed so."""
    looked = times_to(runs, LEVELS[0])
    pairs = zip(runs, looked.seconds, strict=True)
    seconds = [s if run.undisturbed_s is None else run.undisturbed_s for run, s in pairs]
    return Reached(seconds, looked.world_steps, looked.seeds)


def test_rates(runs: list[Run]) -> list[float]:
    """Contacts per 100 m on test worlds, one number per seed."""
    return [run.test[0] for run in runs if run.test is not None]


def _contender(name: str) -> Contender:
    return next(contender for contender in CONTENDERS if contender.name == name)


def _read(path: Path) -> Run:
    record = read_record(path)
    looks = [Look(*look) for look in record.pop("looks")]
    return Run(**record, looks=looks)
