"""The fault campaign: real processes, seeded faults, and a judge.

    python tests/campaigns/faults.py [--runs 200] [--parallel 4] [--json] [--keep FOLDER]

Each run starts `reflexarc run --record` and a body that sends its retinas through the script of
one seed; then once a `kill -9` of the body and one of the runtime. Exit status 1: something that
must never be was. Bounds missed because the machine did not wake the body are counted apart.
"""

import argparse
import dataclasses
import json
import sys
import tempfile
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))  # the tests' support package

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_sim_bridge.body.faults.script import KINDS
from support.fault_judge import MS
from support.fault_runs import (
    Outcome,
    fault_run,
    free_ports,
    killed_body_run,
    killed_runtime_run,
)
from support.policies import exported


def campaign(seeds: Sequence[int], folder: Path, parallel: int = 4) -> list[Outcome]:
    """Run the scripts of these seeds, and the two kills; outcomes in this order."""
    policies = _policies(folder)
    ports = iter(free_ports(len(seeds) + 2))
    jobs: list[Callable[[], Outcome]] = [
        _job(fault_run, seed, policies[seed // len(KINDS) % len(policies)], next(ports), folder)
        for seed in seeds
    ]
    jobs.append(_job(killed_body_run, policies[0], next(ports), folder))
    jobs.append(_job(killed_runtime_run, policies[0], next(ports), folder))
    with ThreadPoolExecutor(parallel) as pool:
        return [future.result() for future in [pool.submit(job) for job in jobs]]


def main() -> int:
    """Run it and print a table, or one JSON object."""
    arguments = _arguments()
    seeds = range(arguments.first, arguments.first + arguments.runs)
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()):
            raise SystemExit(f"--keep: {folder}: expected an empty folder; choose another one")
        outcomes = campaign(seeds, folder, arguments.parallel)
    report = summary(outcomes)
    print(json.dumps(report) if arguments.json else table(report))
    return 1 if report["failures"] else 0


def summary(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Figures by kind, and everything that went wrong."""
    kinds = list(dict.fromkeys(outcome.kind for outcome in outcomes))
    return {
        "runs": len(outcomes),
        "kinds": {kind: _figures([o for o in outcomes if o.kind == kind]) for kind in kinds},
        "all": _figures(outcomes),
        "failures": {o.name: o.failures for o in outcomes if o.failures},
        "oversleeps": {o.name: o.oversleeps for o in outcomes if o.oversleeps},
    }


def table(report: dict[str, Any]) -> str:
    """The same for a person, as Markdown."""
    lines = [
        "| kind | runs | stops | ms to safe: median | p99 | worst "
        "| overslept: how many, worst | stopped by "
        "| told: how many, worst | verdicts seen "
        "| replays identical |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    lines += [_row(kind, figures) for kind, figures in report["kinds"].items()]
    lines += [_row("**all**", report["all"]), ""]
    figures = report["all"]
    lines.append(
        f"{figures['ticks']} ticks; {figures['sent']} messages sent by judged bodies, "
        f"{figures['lost']} of them never arrived; {figures['over the bound']} stops over the "
        f"bound, {figures['overslept']} of them overslept; latest wake-up of a body "
        f"{figures['latest look, ms']} ms, of a runtime {figures['latest tick, ms']} ms"
    )
    lines += [f"FAILED {name}: {'; '.join(what)}" for name, what in report["failures"].items()]
    lines += [f"OVERSLEPT {name}: {'; '.join(w)}" for name, w in report["oversleeps"].items()]
    return "\n".join(lines)


def _figures(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    stops = [o for outcome in outcomes for o in outcome.outages if o.to_safe_ns is not None]
    times_ms = [(s.to_safe_ns or 0) / MS for s in stops if not s.is_the_machine_s]
    overslept_ms = [(s.to_safe_ns or 0) / MS for s in stops if s.is_the_machine_s]
    told_ms = [stop.to_told_ns / MS for stop in stops if stop.to_told_ns is not None]
    median, p99, worst = np.percentile(times_ms, [50, 99, 100]) if times_ms else (None,) * 3
    return {
        "runs": len(outcomes),
        "stops": len(stops),
        "median": median,
        "p99": p99,
        "worst": worst,
        "told": sum(stop.told_ns is not None for stop in stops),
        "told, worst": max(told_ms, default=None),
        "over the bound": sum(stop.is_late for stop in stops),
        "overslept": len(overslept_ms),
        "overslept, worst": max(overslept_ms, default=None),
        "causes": _counted([stop.cause for stop in stops]),
        "verdicts": _counted([v for outcome in outcomes for v in outcome.verdicts]),
        "replayed": sum(outcome.replayed for outcome in outcomes),
        "failed": sum(bool(outcome.failures) for outcome in outcomes),
        "ticks": sum(outcome.ticks for outcome in outcomes),
        "sent": sum(outcome.sent for outcome in outcomes),
        "lost": sum(max(0, o.sent - o.recorded) for o in outcomes if o.sent),
        "latest look, ms": round(max((o.worst_look_ms for o in outcomes), default=0.0), 1),
        "latest tick, ms": round(max((o.worst_tick_ms for o in outcomes), default=0.0), 1),
    }


def _row(kind: str, figures: dict[str, Any]) -> str:
    times = [
        "–" if figures[name] is None else f"{figures[name]:.0f}"
        for name in ("median", "p99", "worst")
    ]
    causes = ", ".join(f"{name} {count}" for name, count in figures["causes"].items()) or "–"
    verdicts = ", ".join(name for name in figures["verdicts"] if name not in ("OK", "STOPPED"))
    replays = f"{figures['replayed']} of {figures['runs']}"
    told, overslept = (_counted_worst(figures, name) for name in ("told", "overslept"))
    cells = [kind, figures["runs"], figures["stops"], *times, overslept, causes, told, verdicts]
    cells.append(replays)
    return "| " + " | ".join(map(str, cells)) + " |"


def _counted_worst(figures: dict[str, Any], name: str) -> str:
    return f"{figures[name]}, {figures[f'{name}, worst']:.0f}" if figures[name] else "–"


def _counted(names: Sequence[str]) -> dict[str, int]:
    return {name: names.count(name) for name in sorted(set(names))}


def _job(run: Callable[..., Outcome], *arguments: Any) -> Callable[[], Outcome]:
    """A run that cannot take the campaign down with it."""

    def job() -> Outcome:
        try:
            return run(*arguments)
        except Exception as error:  # a run that breaks is a failure of that run
            name = getattr(run, "__name__", "run")
            return Outcome(f"{name}{arguments[:1]}", "broken", failures=[f"{error!r}"[:600]])

    return job


def _policies(folder: Path) -> list[Path]:
    """Two exported policies of random weights: one sees one retina, one the last three."""
    paths = []
    for frames in (1, 3):
        path = folder / f"policy-{frames}.onnx"
        contract = PolicyContract()
        retina: RetinaSpec = dataclasses.replace(contract.retina, frames=frames)
        path.write_bytes(exported(dataclasses.replace(contract, retina=retina), seed=frames))
        paths.append(path)
    return paths


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--parallel", type=int, default=4)
    parser.add_argument("--keep", type=Path, help="keep the logs here")
    parser.add_argument("--json", action="store_true")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
