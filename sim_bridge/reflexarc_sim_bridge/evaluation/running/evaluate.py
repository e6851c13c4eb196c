"""The suite from Python: policies, texts or objects in; results and score cards out."""

import json
import math
import os
from collections.abc import Iterable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.files import write_atomically
from reflexarc_sim_bridge.evaluation.protocol.contender import Contender
from reflexarc_sim_bridge.evaluation.protocol.entrant import Entrant
from reflexarc_sim_bridge.evaluation.protocol.results import Results
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import Suite, suite_named
from reflexarc_sim_bridge.evaluation.running.run_suite import BOTH, RunOptions, SuiteRun, run_suite
from reflexarc_sim_bridge.evaluation.scoring.score_card import ScoreCard
from reflexarc_sim_bridge.evaluation.scoring.suite_scores import score_cards

RESULTS, TIMES = "results.json", "times.json"


def evaluate(
    policies: Iterable[str | Path | object] | str | Path | object,
    suite: str | Path | Suite = "lite",
    *,
    families: Sequence[str] = (),
    settings: Sequence[Setting] = BOTH,
    rate_hz: float | None = None,
    guard: bool = False,
    jobs: int = 0,
    out: Path | str | None = None,
    resume: bool = False,
) -> Results:
    """Measure policies in all worlds of a suite, beside an agent that never steers.

    `reflexarc.evaluate("runs/reflex-0/policy.onnx")` takes about half a minute. Files and texts are
    measured in worker processes; an object is copied and measured in this one, cell by cell. The
    same input gives the same results to the last digit, on any number of processes.
    `score_cards(results)` (`reflexarc_sim_bridge.evaluation.scoring.suite_scores`) has the scores.

    Args:
        policies: one or more: paths of exported files, `"module:Class"` or `"file.py:Class"`, or
            objects with `contract` and `decide`.
        suite: the name of one that is shipped, its file, or the suite itself.
        families: only these of its families.
        settings: the robot's rate and body, the field's, or both.
        rate_hz: decides so often on the robot, instead of what its contract says.
        guard: drives behind the guard that a robot has.
        jobs: processes; 0 for as many as there are processors.
        out: folder for `results.json`, `times.json` and what is kept in case of an interruption.
        resume: go on with an interrupted run in that folder.

    Raises:
        ReflexarcError: a policy cannot be loaded or cannot drive; in one line.
    """
    asked = suite if isinstance(suite, Suite) else suite_named(str(suite))
    folder = None if out is None else Path(out)
    entrants = named_apart([_entrant(each, guard, rate_hz) for each in _several(policies)])
    run = run_suite(
        asked.only(tuple(families)) if families else asked,
        entrants,
        settings,
        RunOptions(jobs or processors(), folder, resume),
    )
    if folder is not None:
        write_results(folder, run, score_cards(run.results))
    return run.results


def processors() -> int:
    """How many this process may use."""
    return len(os.sched_getaffinity(0))


def write_results(folder: Path, run: SuiteRun, cards: Sequence[ScoreCard]) -> None:
    """Write results and scores, and in a file of its own what differs from run to run."""
    write_atomically(folder / RESULTS, _text(document_of(run.results, cards)))
    write_atomically(
        folder / TIMES, _text({name: times._asdict() for name, times in run.times.items()})
    )


def document_of(results: Results, cards: Sequence[ScoreCard]) -> dict[str, Any]:
    """The content of `results.json`, as plain values."""
    return {**results.to_json(), "scores": [asdict(card) for card in cards]}


def plain_numbers(value: Any) -> Any:
    """The same with None where a number is none, or without end: JSON has neither."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: plain_numbers(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [plain_numbers(each) for each in value]
    return value


def named_apart(entrants: Sequence[Entrant | Contender]) -> list[Entrant | Contender]:
    """Objects of one class get numbers; files and texts have names of their own."""
    seen: dict[str, int] = {}
    apart = list[Entrant | Contender]()
    for each in entrants:
        count = seen[each.name] = seen.get(each.name, 0) + 1
        is_another = isinstance(each, Contender) and count > 1
        apart.append(replace(each, name=f"{each.name} {count}") if is_another else each)
    return apart


def _several(policies: Any) -> list[Any]:
    is_one = isinstance(policies, str | Path) or hasattr(policies, "decide")
    return [policies] if is_one else list(policies)


def _entrant(given: Any, guard: bool, rate_hz: float | None) -> Entrant | Contender:
    if isinstance(given, str | Path):
        return Entrant(str(given), str(given), guard, rate_hz)
    contract = getattr(given, "contract", None)
    if not isinstance(contract, PolicyContract) or not callable(getattr(given, "decide", None)):
        what = type(given).__name__
        raise UsageError(f"evaluate: expected an object with `contract` and `decide`, got {what}")
    if rate_hz is not None:
        contract = replace(contract, rate_hz=rate_hz)
    sees = str(getattr(getattr(given, "ORIGIN", None), "sees", ""))
    return Contender(type(given).__name__, given, contract, sees == "ranges", guard)


def _text(document: dict[str, Any]) -> bytes:
    return (json.dumps(plain_numbers(document), allow_nan=False) + "\n").encode()
