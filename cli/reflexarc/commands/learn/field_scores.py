"""The reference field's figure of anybody: contacts per 100 m, or how far who turns gets."""

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass

from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_sim_bridge.evaluation.driving.drive import drive
from reflexarc_sim_bridge.evaluation.metrics.sums import Sums, sums_of
from reflexarc_sim_bridge.evaluation.protocol.contender import BLIND, Contender, contender_of
from reflexarc_sim_bridge.evaluation.protocol.foreign_code import foreign_code
from reflexarc_sim_bridge.evaluation.protocol.results import row_of
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting, as_driven
from reflexarc_sim_bridge.evaluation.protocol.suite import Suite, SuiteCell, SuiteFamily
from reflexarc_sim_bridge.evaluation.reference_field import FieldScore, measure
from reflexarc_sim_bridge.evaluation.scoring.cell_figures import (
    Interval,
    mean_farthest_m,
    percentile_interval,
)
from reflexarc_sim_bridge.evaluation.scoring.world_draws import world_draws
from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy
from reflexarc_sim_bridge.worlds.files import world_named
from reflexarc_sim_bridge.worlds.reference_contract import WORLD_NAME
from reflexarc_sim_bridge.worlds.world import WorldSource

MOST_TURNERS = 256
"""A body that turns is followed step by step for a minute, and so takes memory."""
TURNER_S = 60.0

Bar = Callable[[str, int], AbstractContextManager[Callable[[int, int], None]]]


@dataclass(frozen=True)
class FieldPlan:
    """How the field is measured."""

    agents: int
    steps: int
    world: str = ""
    """Another world than the reference's."""
    rate_hz: float | None = None
    """Decides so often, instead of once a step of the world."""

    def worlds(self, contender: Contender) -> WorldSource:
        """The world, at this rate, as the contender's senses show it."""
        source = world_named(self.world or WORLD_NAME)
        if self.rate_hz is None and not contender.sees_ranges:
            return source
        rate_hz = self.rate_hz or 1.0 / source.drawn(0).dt_s
        return as_driven(source, rate_hz, None, contender.sees_ranges)


def field_scores(
    contenders: Sequence[Contender], plan: FieldPlan, bar: Bar
) -> dict[str, FieldScore]:
    """Contacts of those who move sideways, after those of an agent that never steers."""
    scores = {}
    for each in [contender_of(BLIND), *contenders]:
        with bar(each.name, plan.steps) as progress:
            scores[each.name] = measure(
                each.policy,
                each.contract,
                agents=plan.agents,
                steps=plan.steps,
                world=plan.worlds(each),
                guard=GuardSettings.of(each.contract) if each.is_guarded else None,
                progress=progress,
                name=each.name,
            )
    return scores


def distances(contenders: Sequence[Contender], plan: FieldPlan) -> dict[str, Interval]:
    """How far those get that turn; before each, an agent of its speed that never does."""
    found = {}
    for each in contenders:
        blind = Contender(BLIND, BlindPolicy(len(each.contract.actions)), each.contract)
        for name, one in ((f"{BLIND}, as {each.name}", blind), (each.name, each)):
            with foreign_code(name):
                found[name] = _distance(_driven(one, plan))
    return found


def _driven(contender: Contender, plan: FieldPlan) -> Sums:
    cell = SuiteCell("field", plan.world or WORLD_NAME)
    families = (SuiteFamily("field", cells=(cell,)),)
    worlds = min(plan.agents, MOST_TURNERS)
    suite = Suite("field", 1, worlds=worlds, lanes=1, turner_s=TURNER_S, families=families)
    setting = Setting.FIELD if plan.rate_hz is None else Setting.ROBOT
    return sums_of(drive(contender, cell, suite, setting))


def _distance(sums: Sums) -> Interval:
    row = row_of("", Setting.FIELD, "field", "field", sums)
    worlds = len(row.array("agents"))
    return percentile_interval(mean_farthest_m(row, world_draws(worlds)), worlds)
