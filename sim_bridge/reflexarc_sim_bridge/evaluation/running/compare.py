"""Compares a new policy with an old one in all families of a suite, shared among processes.

A family is one task: both drive the same validation worlds until it is decided, or until the last
look. What is said of a family follows from the two policies, its worlds and the terms alone: not
from the number of processes, nor from the other families.
"""

import json
import sys
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any, Self

from reflexarc_runtime.config.fill import fill
from reflexarc_runtime.config.source import MappingSource
from reflexarc_runtime.crew.crew import Crew
from reflexarc_runtime.crew.worker_process import Failure, Task
from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.evaluation.driving.paired_drive import PAIRED_WORLDS, Pair, drive_pair
from reflexarc_sim_bridge.evaluation.protocol.contender import Contender
from reflexarc_sim_bridge.evaluation.protocol.entrant import Entrant
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import Suite, SuiteCell, SuiteFamily
from reflexarc_sim_bridge.evaluation.scoring.regression import (
    FamilyVerdict,
    Look,
    is_decided,
    judge,
    look_at,
)
from reflexarc_sim_bridge.native.cache import has_compiled

_WORKER = "reflexarc_sim_bridge.evaluation.running.compare_worker"


@dataclass(frozen=True)
class Terms:
    """What is borne, and how sure one has to be."""

    margin: float = 0.1
    """Largest loss that is borne, as a share: 0.1 for a tenth more contacts."""
    alpha: float = 0.05
    """Family-wise level."""
    worlds: int = PAIRED_WORLDS
    """Validation worlds."""
    lane: int = 0
    """Other lanes begin elsewhere in the same worlds: another draw of the same experiment."""


@dataclass(frozen=True)
class Comparison:
    """Two policies in one family; what any process can do for itself."""

    new: Entrant
    old: Entrant
    cells: tuple[SuiteCell, ...]
    setting: Setting
    terms: Terms
    families: int
    """How many families are judged together."""

    def to_plain(self) -> dict[str, Any]:
        """As plain JSON values."""
        plain: dict[str, Any] = json.loads(json.dumps(asdict(self)))
        return plain

    @classmethod
    def from_plain(cls, document: Mapping[str, Any]) -> Self:
        """What `to_plain` gave."""
        return fill(cls, MappingSource(document, "comparison"), require_all=True)

    def looks(self) -> list[Look]:
        """Drive both until it is decided, or until the last look."""
        found = list[Look]()

        def is_enough(pair: Pair) -> bool:
            found.append(look_at(pair.new, pair.old))
            return is_decided(found, self.terms.margin, self.terms.alpha, self.families)

        new, old = self.new.contender(), self.old.contender()
        terms = self.terms
        drive_pair(new, old, self.cells, self.setting, is_enough, terms.worlds, terms.lane)
        return found


def compare(
    new: Entrant,
    old: Entrant,
    suite: Suite,
    setting: Setting,
    terms: Terms | None = None,
    jobs: int = 1,
    progress: Callable[[float, float], None] = lambda done, total: None,
) -> tuple[FamilyVerdict, ...]:
    """The verdict on each family that has cells that count.

    Args:
        new: who is judged.
        old: whom it is compared with.
        suite: whose worlds; its amounts play no part.
        setting: at which rate, with which body.
        terms: what is borne, and how sure one has to be.
        jobs: processes.
        progress: called with the families done and the families in all.

    Raises:
        ReflexarcError: a contender cannot be made or cannot drive; one turns and the other not.
    """
    terms = terms or Terms()
    _check_alike(new.contender(), old.contender())
    families = {family.name: _counted(family) for family in suite.families if _counted(family)}
    if not families:
        raise UsageError(f"{suite.title}: expected a family with cells that count, got none")
    tasks = [
        _task(name, Comparison(new, old, cells, setting, terms, len(families)))
        for name, cells in sorted(families.items(), key=lambda item: -len(item[1]))
    ]
    looks = _done(tasks, jobs, progress)
    return judge({name: looks[name] for name in families}, terms.margin, terms.alpha)


def _done(
    tasks: list[Task], jobs: int, progress: Callable[[float, float], None]
) -> dict[str, list[Look]]:
    """The looks at each family, by its name."""
    looks = dict[str, list[Look]]()
    progress(0, len(tasks))
    with Crew(_WORKER, tasks, jobs, first_alone=not has_compiled()) as crew:
        for outcome in crew.outcomes(lambda: False):
            if isinstance(outcome, Failure):
                raise UsageError(f"{outcome.task.key}: {outcome.reason}")
            looks[outcome.task.key] = [Look(*look) for look in outcome.answer["looks"]]
            progress(len(looks), len(tasks))
    return looks


def _task(name: str, comparison: Comparison) -> Task:
    return Task(name, {"comparison": comparison.to_plain(), "path": sys.path})


def _counted(family: SuiteFamily) -> tuple[SuiteCell, ...]:
    return tuple(cell for cell in family.cells if cell.counts)


def _check_alike(new: Contender, old: Contender) -> None:
    if new.turns != old.turns:
        turning, other = (new, old) if new.turns else (old, new)
        raise UsageError(
            f"expected two bodies of one kind, but {turning.name} turns and {other.name} does not"
        )
