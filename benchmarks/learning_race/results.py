"""What the runs of a contender say together.

Times are to the first of two looks in a row that pass a level; a seed that never does counts as the
run's whole length. A level that fewer than 8 of 10 seeds reach is censored: only that it takes
longer is known. Everything else is an interquartile mean over seeds with a 95 % bootstrap interval.
"""

from dataclasses import dataclass
from pathlib import Path

from learning_race.contenders import CONTENDERS, Contender
from learning_race.judge import LEVELS, Look, reached
from learning_race.record import read_record
from reflexarc_sim_bridge.evaluation.statistics import Estimate, estimate

LEAST_SHARE = 0.8
"""Of the seeds that have to reach a level."""


@dataclass(frozen=True)
class Run:
    """One run, as its file has it."""

    contender: str
    settings: str
    seed: int
    budget_s: float
    seconds: float
    """How long it learned."""
    looks: list[Look]
    test: list[float] | None = None
    """Contacts per 100 m on test worlds, and its interval over agents; none of a cold run."""
    undisturbed_s: float | None = None
    """To the first level without a look; none where it was not reached."""


@dataclass(frozen=True)
class Reached:
    """A level over the seeds of a contender."""

    seconds: list[float]
    """Of every seed; the run's length where it did not."""
    world_steps: list[float]
    seeds: int
    """That reached it."""

    @property
    def is_censored(self) -> bool:
        """Whether too few did."""
        return self.seeds < LEAST_SHARE * len(self.seconds)

    @property
    def time_s(self) -> Estimate:
        """To the level."""
        return estimate(self.seconds)


def read_runs(out: Path, *, cold: bool = False) -> dict[str, list[Run]]:
    """Runs by contender, in the contenders' order."""
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
    """When, and after how many steps of the world, a level was reached."""
    looks = [reached(run.looks, level) for run in runs]
    unreached = [Look(run.seconds, run.looks[-1].world_steps, 0.0) for run in runs]
    ends = [look or end for look, end in zip(looks, unreached, strict=True)]
    count = sum(look is not None for look in looks)
    seconds, steps = [end.seconds for end in ends], [float(end.world_steps) for end in ends]
    return Reached(seconds, steps, count)


def undisturbed(runs: list[Run]) -> Reached:
    """The same for the first level without looks, where every run that reached it was timed so."""
    looked = times_to(runs, LEVELS[0])
    pairs = zip(runs, looked.seconds, strict=True)
    seconds = [s if run.undisturbed_s is None else run.undisturbed_s for run, s in pairs]
    return Reached(seconds, looked.world_steps, looked.seeds)


def test_rates(runs: list[Run]) -> list[float]:
    """Contacts per 100 m on test worlds, a number a seed."""
    return [run.test[0] for run in runs if run.test is not None]


def _contender(name: str) -> Contender:
    return next(contender for contender in CONTENDERS if contender.name == name)


def _read(path: Path) -> Run:
    record = read_record(path)
    looks = [Look(*look) for look in record.pop("looks")]
    return Run(**record, looks=looks)
