"""Does one unit of a suite, in this process: a pure function of the unit."""

from collections.abc import Callable
from typing import Any

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.evaluation.driving.drive import drive
from reflexarc_sim_bridge.evaluation.metrics.sums import sums_of
from reflexarc_sim_bridge.evaluation.protocol.contender import Contender
from reflexarc_sim_bridge.evaluation.protocol.foreign_code import foreign_code
from reflexarc_sim_bridge.evaluation.protocol.results import plain_sums
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import Suite, SuiteCell
from reflexarc_sim_bridge.evaluation.running.chance import same_chance
from reflexarc_sim_bridge.evaluation.running.limit_plugs import LIMITS
from reflexarc_sim_bridge.evaluation.running.suite_unit import SuiteUnit, evaluation_code

PlainSums = dict[str, list[Any]]
"""By name: one value a world, or one row of values."""


def do_unit(unit: SuiteUnit) -> PlainSums:
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
        return plain_sums(LIMITS[unit.limit](unit.cell, suite, motion))
    if unit.entrant.content_hash() != unit.content:
        raise UsageError("it has changed since the run began; begin it again")
    return drive_alike(unit.entrant.contender, unit.cell, suite, unit.setting)


def drive_alike(
    make: Callable[[], Contender], cell: SuiteCell, suite: Suite, setting: Setting
) -> PlainSums:
    """Drive whoever is made, with the same chance as everybody.

    Raises:
        ReflexarcError: it cannot drive there, or its code raised something.
    """
    with foreign_code(), same_chance():
        return plain_sums(sums_of(drive(make(), cell, suite, setting)))
