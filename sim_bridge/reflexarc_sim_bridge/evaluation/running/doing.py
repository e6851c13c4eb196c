"""Does one unit of a suite, in this process: a pure function of the unit, but for its times."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Self

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import ReflexarcError, UsageError, first_line
from reflexarc_sim_bridge.evaluation.driving.drive import drive
from reflexarc_sim_bridge.evaluation.metrics.sums import Sums, sums_of
from reflexarc_sim_bridge.evaluation.protocol.contender import Contender
from reflexarc_sim_bridge.evaluation.protocol.results import plain_sums
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import Suite, SuiteCell
from reflexarc_sim_bridge.evaluation.running.chance import same_chance
from reflexarc_sim_bridge.evaluation.running.limit_plugs import LIMITS
from reflexarc_sim_bridge.evaluation.running.suite_unit import SuiteUnit, evaluation_code
from reflexarc_sim_bridge.evaluation.running.timed_policy import TimedPolicy


@dataclass(frozen=True)
class Measured:
    """What came of a unit."""

    sums: dict[str, list[float]]
    """By name: one value a world."""
    decisions: int
    """Of single agents; 0 for a limit."""
    decided_s: float
    """Time that they took."""

    @classmethod
    def from_plain(cls, document: Mapping[str, Any]) -> Self:
        """What `dataclasses.asdict` gave.

        Raises:
            KeyError, TypeError, ValueError, AttributeError: it is none of this version.
        """
        sums = {str(name): list(map(float, each)) for name, each in document["sums"].items()}
        return cls(sums, int(document["decisions"]), float(document["decided_s"]))


def do_unit(unit: SuiteUnit) -> Measured:
    """Make the contender of a unit anew, and drive it.

    Raises:
        ReflexarcError: the contender, or the code, is no longer what it was when the unit was made;
            or it cannot drive there.
    """
    suite = unit.amount.suite(unit.cell)
    if unit.code != evaluation_code():
        raise UsageError("the code has changed since the run began; begin it again")
    if unit.entrant is None:
        motion = PolicyContract.from_json(unit.motion)
        return Measured(plain_sums(LIMITS[unit.limit](unit.cell, suite, motion)), 0, 0.0)
    if unit.entrant.content_hash() != unit.content:
        raise UsageError("it has changed since the run began; begin it again")
    return drive_timed(unit.entrant.contender, unit.cell, suite, unit.setting)


def drive_timed(
    make: Callable[[], Contender], cell: SuiteCell, suite: Suite, setting: Setting
) -> Measured:
    """Drive whoever is made, with a watch.

    Raises:
        ReflexarcError: it cannot drive there, or its code raised something.
    """
    try:
        with same_chance():
            contender = make()
            watch = TimedPolicy(contender.policy)
            sums = _sums(replace(contender, policy=watch), cell, suite, setting)
    except ReflexarcError:
        raise
    except Exception as error:  # somebody else's code decides
        raise UsageError(f"it raised {type(error).__name__}: {first_line(error)}") from error
    return Measured(plain_sums(sums), watch.decisions, watch.decided_s)


def _sums(contender: Any, cell: SuiteCell, suite: Suite, setting: Setting) -> Sums:
    return sums_of(drive(contender, cell, suite, setting))
