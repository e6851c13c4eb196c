"""The search that every baseline gets: the same number of random settings, on the same worlds.

A trial is a setting drawn from the baseline's spans (`SEARCHED`), each parameter by itself, evenly
or evenly in its logarithm; its figure is contacts per 100 m in the baseline's home world, on
validation seeds only. The setting that the baseline ships with is measured beside them and is no
trial. The same baseline, budget and seed give the same table.
"""

import dataclasses
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np

from reflexarc_baselines.baseline import Baseline, Remembering, Sees, Span
from reflexarc_baselines.registry import baseline_named
from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.evaluation.protocol.setting import FIELD_RATE_HZ, as_driven
from reflexarc_sim_bridge.evaluation.reference_field import measure
from reflexarc_sim_bridge.worlds.files import world_named
from reflexarc_sim_bridge.worlds.seeds import validation_seeds

Setting: TypeAlias = Mapping[str, float | int]
"""Value of each searched parameter."""
Rate: TypeAlias = Callable[["Baseline | Remembering"], float]
"""Contacts per 100 m; less is better."""


@dataclass(frozen=True)
class SearchBudget:
    """What a search may spend; the default is what every baseline gets."""

    trials: int = 64
    agents: int = 256
    steps: int = 200

    def __post_init__(self) -> None:
        for name, value in dataclasses.asdict(self).items():
            if value < 1:
                raise UsageError(f"search: expected {name} ≥ 1, got {value}")


@dataclass(frozen=True)
class TriedSetting:
    """A setting and its figure."""

    setting: Setting
    contacts_per_100m: float


@dataclass(frozen=True)
class SearchReport:
    """What a search found."""

    name: str
    world: str
    seed: int
    budget: SearchBudget
    shipped: TriedSetting
    """The setting that the baseline ships with."""
    trials: tuple[TriedSetting, ...]
    """Those that were drawn, the best first."""


def search(
    name: str,
    *,
    budget: SearchBudget | None = None,
    seed: int = 0,
    progress: Callable[[int, int], None] | None = None,
) -> SearchReport:
    """Measure random settings of a baseline on validation worlds.

    Args:
        name: in the registry.
        budget: the usual one if None.
        seed: of the drawn settings.
        progress: called after each measurement with those done and those in all.

    Raises:
        UsageError: no baseline has this name, or it has nothing to search.
    """
    baseline, budget = baseline_named(name), budget or SearchBudget()
    if not baseline.SEARCHED:
        raise UsageError(f"search: expected a baseline with free parameters, got {name}")
    home, rate = baseline.ORIGIN.home_world, rate_of(baseline, budget)
    settings = drawn_settings(baseline.SEARCHED, budget.trials, seed)
    shipped = {parameter: getattr(baseline, parameter) for parameter in baseline.SEARCHED}
    measured = []
    for setting in (shipped, *settings):
        measured.append(TriedSetting(setting, rate(with_setting(baseline, setting))))
        if progress is not None:
            progress(len(measured), 1 + budget.trials)
    best_first = sorted(measured[1:], key=lambda trial: trial.contacts_per_100m)
    return SearchReport(name, home, seed, budget, measured[0], tuple(best_first))


def rate_of(baseline: Baseline | Remembering, budget: SearchBudget) -> Rate:
    """Measures in a baseline's home world as its senses show it, on validation seeds."""
    home, sees_ranges = baseline.ORIGIN.home_world, baseline.ORIGIN.sees is Sees.RANGES
    world = as_driven(world_named(home), FIELD_RATE_HZ, None, sees_ranges)
    seeds = validation_seeds(budget.agents)

    def rate(candidate: Baseline | Remembering) -> float:
        score = measure(
            candidate,
            candidate.contract,
            agents=budget.agents,
            steps=budget.steps,
            seeds=seeds,
            world=world,
        )
        return score.contacts_per_100m

    return rate


def drawn_settings(spans: Mapping[str, Span], count: int, seed: int) -> list[Setting]:
    """Settings drawn from spans, each parameter by itself."""
    generator = np.random.default_rng(seed)
    return [{name: _drawn(span, generator) for name, span in spans.items()} for _ in range(count)]


def with_setting(baseline: Any, setting: Setting) -> Any:
    """The same baseline with other parameters."""
    return dataclasses.replace(baseline, **setting)


def _drawn(span: Span, generator: np.random.Generator) -> float | int:
    if span.is_whole:
        return int(generator.integers(round(span.low), round(span.high), endpoint=True))
    if span.is_log:
        low, high = math.log(span.low), math.log(span.high)
        return math.exp(generator.uniform(low, high))
    return float(generator.uniform(span.low, span.high))
