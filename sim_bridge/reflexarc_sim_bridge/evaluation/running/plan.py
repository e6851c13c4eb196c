"""What there is to do for a suite, and whose results it becomes."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.evaluation.protocol.contender import Contender
from reflexarc_sim_bridge.evaluation.protocol.entrant import Entrant
from reflexarc_sim_bridge.evaluation.protocol.moving_like import moving_like, who_words
from reflexarc_sim_bridge.evaluation.protocol.results import ResultRow
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import Suite, SuiteCell
from reflexarc_sim_bridge.evaluation.running.limit_plugs import LIMITS, ORACLE
from reflexarc_sim_bridge.evaluation.running.suite_unit import Amount, SuiteUnit, evaluation_code

_ORACLE_WEIGHT = 10.0
"""An oracle plans for so many times as long as a contender drives, unless that is kept on disk."""


@dataclass(frozen=True)
class Starter:
    """Who is measured: an entrant that any process can make, or an object of this process."""

    contender: Contender
    """As made once, for its contract."""
    entrant: Entrant | None
    content: str
    """See `Entrant.content_hash`."""


@dataclass(frozen=True)
class Job:
    """A row that is wanted, and the unit whose sums it will hold."""

    row: ResultRow
    """Without its sums."""
    cell: SuiteCell
    key: str
    """Jobs with equal keys have equal sums."""
    unit: SuiteUnit | None
    """None: only this process can do it."""
    starter: Starter | None
    """None: a limit."""

    @property
    def where(self) -> str:
        """Who and where, for complaints."""
        row = self.row
        return f"{row.contender} in {row.family}/{row.tier} ({row.setting})"

    @property
    def weight(self) -> float:
        """About how long it takes, in no unit: its decisions a second, more for an oracle."""
        if self.starter is not None:
            return self.row.setting.rate_hz(self.starter.contender.contract)
        assert self.unit is not None
        rate_hz = PolicyContract.from_json(self.unit.motion).rate_hz
        return rate_hz * (_ORACLE_WEIGHT if self.unit.limit == ORACLE else 1.0)


def starters_of(entrants: Sequence[Entrant | Contender]) -> list[Starter]:
    """Make each once, and complain early.

    Raises:
        ReflexarcError: one cannot be made; or two have one name.
    """
    names = [each.name for each in entrants]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise UsageError(f"contenders: expected distinct names, got twice: {', '.join(twice)}")
    return [
        Starter(each.contender(), each, each.content_hash())
        if isinstance(each, Entrant)
        else Starter(each, None, "")
        for each in entrants
    ]


def plan_suite(
    suite: Suite, starters: Sequence[Starter], settings: Sequence[Setting]
) -> tuple[list[Job], list[Job]]:
    """The rows of all starters, and those of the limits of all their motions, in their order."""
    jobs = [
        _job(suite, family.name, cell, starter, setting)
        for starter in starters
        for setting in settings
        for family, cell in suite.cells
    ]
    limits = {
        (job.row.contender, job.row.family, job.row.tier): job
        for starter in starters
        for setting in settings
        for job in _limit_jobs(suite, starter, setting)
    }
    return jobs, list(limits.values())


def _job(suite: Suite, family: str, cell: SuiteCell, starter: Starter, setting: Setting) -> Job:
    contract = starter.contender.contract
    holders = {name: _holder(name, starter, setting) for name in LIMITS}
    row = ResultRow(starter.contender.name, setting, family, cell.tier, {}, holders)
    if starter.entrant is None:
        return Job(row, cell, f"here: {'/'.join(row.key)}", None, starter)
    unit = SuiteUnit(
        Amount.of(suite), cell, setting, starter.content, evaluation_code(), starter.entrant
    )
    # A blind agent's contract, and what a range finder sees, follow from its content.
    key = unit.key(setting.rate_hz(contract), setting.body(contract))
    return Job(row, cell, key, unit, starter)


def _limit_jobs(suite: Suite, starter: Starter, setting: Setting) -> Iterator[Job]:
    motion = moving_like(starter.contender.contract, setting)
    for name in LIMITS:
        for family, cell in suite.cells:
            holder = _holder(name, starter, setting)
            row = ResultRow(holder, Setting.ROBOT, family.name, cell.tier, {})
            unit = SuiteUnit(
                amount=Amount.of(suite),
                cell=cell,
                setting=Setting.ROBOT,
                content="",
                code=evaluation_code(),
                limit=name,
                motion=motion.to_json(),
            )
            yield Job(row, cell, unit.key(motion.rate_hz, motion.body), unit, None)


def _holder(name: str, starter: Starter, setting: Setting) -> str:
    return f"{name}: {who_words(moving_like(starter.contender.contract, setting))}"


def filled(job: Job, sums: dict[str, list[Any]]) -> ResultRow:
    """The row of a job that is done."""
    return replace(job.row, sums=sums)
