"""What a suite found out, as plain data: the content of `results.json`.

A row is one contender in one cell and setting: sums over each of its worlds, as in
`metrics/sums.py`. Everything that is printed, drawn or tested is computed from rows.
"""

from dataclasses import asdict, dataclass, field
from typing import Any, Self

import numpy as np

from reflexarc_sim_bridge.evaluation.metrics.sums import Sums
from reflexarc_sim_bridge.evaluation.metrics.track import Floats
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting

FORMAT = 1


@dataclass(frozen=True)
class ResultRow:
    """One contender in one cell."""

    contender: str
    setting: Setting
    family: str
    tier: str
    sums: dict[str, list[Any]]
    """By the name of the sum: one value a world, or one row of values."""
    limits: dict[str, str] = field(default_factory=dict)
    """By the name of a limit, such as `blind`: who holds it for a body that moves like this one."""

    @property
    def key(self) -> tuple[str, Setting, str, str]:
        """What tells rows apart."""
        return self.contender, self.setting, self.family, self.tier

    def array(self, name: str) -> Floats:
        """A sum: (worlds, …)."""
        return np.array(self.sums[name], np.float64)


@dataclass(frozen=True)
class Agent:
    """The specification of a contender, for whoever wants to repeat the measurement."""

    name: str
    source: str
    """File, or module and class."""
    hash: str
    """SHA-256 of the file; empty for code."""
    seed: int | None
    """Of its training."""
    preset: str
    """What it was trained by; empty for others."""
    eye: str
    """In words."""
    motion: str
    body: str
    rate_hz: float
    turns: bool
    tuned: str = ""
    """What was tuned or trained, and where."""
    group: str = ""
    """The same for all files of one preset and configuration, whatever their seeds; empty for
    others."""


@dataclass(frozen=True)
class CellFacts:
    """What a cell of the suite was, for whoever reads the results without it."""

    family: str
    tier: str
    world: str
    clutter: float | None
    counts: bool


@dataclass
class Results:
    """All rows of a suite."""

    suite: str
    """Name and version."""
    version: str
    """Of reflexarc."""
    agents: list[Agent] = field(default_factory=list)
    rows: list[ResultRow] = field(default_factory=list)
    limits: list[ResultRow] = field(default_factory=list)
    """What is possible: their contenders are those that `ResultRow.limits` names."""
    cells: list[CellFacts] = field(default_factory=list)

    def limit(self, row: ResultRow, name: str) -> ResultRow | None:
        """The limit of that name for a row, in the same cell; None where nobody found it."""
        holder = row.limits.get(name)
        for each in self.limits:
            if (each.contender, each.family, each.tier) == (holder, row.family, row.tier):
                return each
        return None

    def to_json(self) -> dict[str, Any]:
        """As plain values."""
        return {"format": FORMAT, **asdict(self)}

    @classmethod
    def from_json(cls, document: dict[str, Any]) -> Self:
        """What `to_json` gave."""
        return cls(
            suite=document["suite"],
            version=document["version"],
            agents=[Agent(**each) for each in document["agents"]],
            rows=[_row_from(each) for each in document["rows"]],
            limits=[_row_from(each) for each in document["limits"]],
            cells=[CellFacts(**each) for each in document["cells"]],
        )


def plain_sums(sums: Sums) -> dict[str, list[Any]]:
    """Sums as plain values."""
    return {name: values.tolist() for name, values in sums.items()}


def row_of(contender: str, setting: Setting, family: str, tier: str, sums: Sums) -> ResultRow:
    """A row from the sums of a track."""
    return ResultRow(contender, setting, family, tier, plain_sums(sums))


def _row_from(document: dict[str, Any]) -> ResultRow:
    return ResultRow(**{**document, "setting": Setting(document["setting"])})
