"""The report on existing runs: table, comparisons and figure."""

from collections.abc import Iterable
from pathlib import Path

from learning_race.figure import draw
from learning_race.judge import LEVELS, reached
from learning_race.results import (
    Reached,
    Run,
    group_of,
    read_runs,
    test_rates,
    times_to,
    undisturbed,
)
from reflexarc_sim_bridge.evaluation.scoring.statistics import Estimate, estimate, ratio_estimate

Runs = dict[str, list[Run]]

HEADER = (
    "contender",
    "group",
    "seeds",
    *(f"time to {level:g}, s" for level in LEVELS),
    f"to {LEVELS[0]:g} without looks, s",
    f"steps to {LEVELS[0]:g}",
    "learned for, s",
    "test worlds, contacts / 100 m",
)


def write_report(out: Path) -> str:
    """Write `learning.md` and `learning.png` into the folder of the runs; returns the text."""
    runs, cold = read_runs(out), read_runs(out, cold=True)
    parts = [_table(HEADER, (_row(name, mine) for name, mine in runs.items()))]
    if cold:
        heading = ("contender", "cold starts", f"time to {LEVELS[0]:g}, s")
        parts.append(_table(heading, (_cold_row(name, mine) for name, mine in cold.items())))
    parts.append("\n".join(f"- {line}" for line in comparisons(runs)))
    text = "\n\n".join(parts) + "\n"
    (out / "learning.md").write_text(text)
    (out / "learning.png").write_bytes(draw(runs))
    return text


def comparisons(runs: Runs) -> list[str]:
    """What the table is for: ours against the best rival, as ratios with 95 % intervals."""
    lines = []
    for group in ("tuned", "default"):
        lines += _time_ratio(runs, _names(runs, "ours"), _names(runs, group), group)
    rivals = [name for group in ("tuned", "default", "matched") for name in _names(runs, group)]
    for name in ("reflex-3s", "online-3s", "reflex-60s", "reflex-deep-60s"):
        if name in runs and rivals:
            best = min(rivals, key=lambda rival: estimate(test_rates(runs[rival])).value)
            ratio = ratio_estimate(test_rates(runs[name]), test_rates(runs[best]))
            lines.append(f"test worlds: {name} has {_shown(ratio)} of the rate of {best}")
    return lines


def _time_ratio(runs: Runs, ours: list[str], rivals: list[str], group: str) -> list[str]:
    level = LEVELS[0]
    times = {name: undisturbed(runs[name]) for name in [*ours, *rivals]}
    ours, rivals = ([n for n in names if not times[n].is_censored] for names in (ours, rivals))
    if not ours or not rivals:
        return [_bound(times, level, group, ours, rivals)]
    mine = min(ours, key=lambda name: times[name].time_s.value)
    best = min(rivals, key=lambda name: times[name].time_s.value)
    ratio = ratio_estimate(times[best].seconds, times[mine].seconds)
    who = f"{best}, the best {group} one, takes {_shown(ratio)} times as long as {mine}"
    return [f"time to {level:g} without looks: {who}"]


def _bound(
    times: dict[str, Reached], level: float, group: str, ours: list[str], rivals: list[str]
) -> str:
    """A bound for the ratio, where no contender of a group reaches the level often enough."""
    slow = [min(t.seconds) for name, t in times.items() if group_of(name) == group]
    if not ours or rivals or not slow:
        return f"time to {level:g} ({group}): no contenders to compare"
    mine = min(times[name].time_s.value for name in ours)
    return (
        f"time to {level:g}: too few seeds of any {group} one reach it; the shortest of their runs "
        f"is {min(slow) / mine:.3g} times as long as the best of ours takes"
    )


def _names(runs: Runs, group: str) -> list[str]:
    return [name for name in runs if group_of(name) == group]


def _row(name: str, runs: list[Run]) -> list[str]:
    times = [_time(runs, level) for level in LEVELS]
    steps = times_to(runs, LEVELS[0])
    thousands = f"{estimate(steps.world_steps).value / 1000:,.0f} k"
    learned = estimate([run.seconds for run in runs]).value
    rate = _shown(estimate(test_rates(runs)))
    shown_steps = "–" if steps.is_censored else thousands
    alone = "–" if steps.is_censored else _shown(undisturbed(runs).time_s)
    return [
        name,
        group_of(name),
        f"{len(runs)}",
        *times,
        alone,
        shown_steps,
        f"{learned:.3g}",
        rate,
    ]


def _cold_row(name: str, runs: list[Run]) -> list[str]:
    return [name, f"{len(runs)}", _time(runs, LEVELS[0])]


def _time(runs: list[Run], level: float) -> str:
    found = times_to(runs, level)
    if found.is_censored:
        in_vain = min(run.seconds for run in runs if reached(run.looks, level) is None)
        return f"> {in_vain:.3g} ({found.seeds} of {len(runs)})"
    return _shown(found.time_s)


def _shown(number: Estimate) -> str:
    return f"{number.value:.3g} [{number.low:.3g}, {number.high:.3g}]"


def _table(header: Iterable[str], rows: Iterable[list[str]]) -> str:
    names = list(header)
    lines = [names, ["---"] * len(names), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)
