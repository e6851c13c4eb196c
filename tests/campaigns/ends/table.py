"""What a campaign has shown, as figures and as a table."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from campaigns.ends.campaign import Campaign
from campaigns.ends.judge import Judgement, Outcome, judged
from campaigns.ends.kinds import KINDS

YOUNG_MS = 1000.0
"""A recording that is killed loses less than a second (docs/logs.md): all of one so young."""
HEAD = (
    "ended",
    "ends",
    "told to stand, ms: median",
    "99 %",
    "worst",
    "bound",
    "over",
    "the machine's",
    "stood, worst ms",
    "rolled, worst mm",
    "logs replayed",
)


def summary(campaign: Campaign) -> dict[str, Any]:
    """Figures by kind, and everything that went wrong."""
    late = [(o, judged(o, campaign.overslept)) for o in campaign.outcomes]
    replays = {r.log: r for r in campaign.replays}
    rows = {kind.name: [o for o in campaign.outcomes if o.kind == kind.name] for kind in KINDS}
    over = [f"{o.kind}: {j}" for o, j in late if j is not None and not j.is_the_machine_s]
    young = {o.log for o in campaign.outcomes if o.lived_ms < YOUNG_MS}
    empty = [r for r in campaign.replays if r.is_empty and r.log in young]
    broken = [r.complaint for r in campaign.replays if r.complaint and r not in empty]
    return {
        "ends": len(campaign.outcomes),
        "kinds": {
            name: _figures(each, [j for o, j in late if o.kind == name], replays)
            for name, each in rows.items()
            if each
        },
        "logs": len(campaign.replays),
        "recovered": sum(r.was_recovered for r in campaign.replays),
        "empty": len(empty),
        "replayed": len(campaign.replays) - len(empty) - len(broken),
        "excused": [f"{o.kind}: {j}" for o, j in late if j is not None and j.is_the_machine_s],
        "failures": [*campaign.failures, *over, *broken],
        "oversleeps": len(campaign.overslept),
        "longest oversleep, ms": max((b - a for a, b in campaign.overslept), default=0) / 1e6,
        "took, s": campaign.took_s,
        "load": campaign.load,
    }


def table(report: dict[str, Any]) -> str:
    """The same for a person, as Markdown."""
    lines = ["| " + " | ".join(HEAD) + " |", "|---" * len(HEAD) + "|"]
    lines += [_row(name, figures) for name, figures in report["kinds"].items()]
    lines += [
        "",
        f"{report['ends']} ends in {report['took, s'] / 60:.0f} minutes, load "
        f"{report['load']:.1f}; {report['replayed']} of {report['logs']} logs replayed, "
        f"{report['recovered']} recovered first, {report['empty']} without a tick, of runtimes "
        f"killed in their first second; a core overslept by more than 1 ms "
        f"{report['oversleeps']} times, at worst by {report['longest oversleep, ms']:.1f} ms",
    ]
    lines += [f"THE MACHINE'S {what}" for what in report["excused"]]
    lines += [f"FAILED {what}" for what in report["failures"]]
    return "\n".join(lines)


def _figures(
    each: Sequence[Outcome], judgements: Sequence[Judgement | None], replays: dict[str, Any]
) -> dict[str, Any]:
    told_ms = [o.told_ms for o in each if o.told_ms is not None]
    over = [j for j in judgements if j is not None]
    logs = [replays[o.log] for o in each if o.log in replays]
    return {
        "ends": len(each),
        "told, ms": _percentiles(told_ms),
        "bound, ms": each[0].bound_ms,
        "over": len(over),
        "the machine's": sum(j.is_the_machine_s for j in over),
        "stood, ms": _worst([o.stand_ms for o in each]),
        "rolled, mm": _worst([o.rolled_mm for o in each]),
        "logs": len(logs),
        "replayed": sum(not log.complaint for log in logs),
    }


def _percentiles(values: Sequence[float]) -> list[float]:
    """Median, 99 of 100, worst; infinite values are none of NumPy's business."""
    if not values:
        return []
    return [float(v) for v in np.percentile(values, [50, 99, 100], method="higher")]


def _worst(each: Sequence[dict[str, float]]) -> dict[str, float]:
    worst: dict[str, float] = {}
    for values in each:
        for name, value in values.items():
            worst[name] = max(value, worst.get(name, 0.0))
    return worst


def _row(name: str, figures: dict[str, Any]) -> str:
    told = [_number(value) for value in figures["told, ms"]] or ["drives on", "", ""]
    bound = "–" if figures["bound, ms"] is None else f"{figures['bound, ms']:.0f}"
    over, excused = figures["over"], figures["the machine's"]
    stood, rolled = (_by_base(figures[key]) for key in ("stood, ms", "rolled, mm"))
    logs = f"{figures['replayed']} of {figures['logs']}" if figures["logs"] else ""
    cells = [name, figures["ends"], *told, bound, over, excused, stood, rolled, logs]
    return "| " + " | ".join(map(str, cells)) + " |"


def _by_base(values: dict[str, float]) -> str:
    return ", ".join(f"{name} {_number(value)}" for name, value in values.items())


def _number(value: float) -> str:
    return "never" if value == math.inf else f"{value:.0f}"
