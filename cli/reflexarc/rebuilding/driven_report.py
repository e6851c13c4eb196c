"""Logs whose moments before contacts were rebuilt and driven on: as data, as text, as Markdown."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from reflexarc.rebuilding.driven_findings import DrivenLog, Tried, WantedDrives
from reflexarc.rebuilding.driven_incidents import LEAST_LEAD_S, drive_incidents
from reflexarc_runtime.errors import ReflexarcError
from reflexarc_runtime.words.shown import plain
from reflexarc_sim_bridge.body.driving_on import DrivenWay

_RECORDED = "recorded policy"


@dataclass(frozen=True)
class DrivenReport:
    """A candidate that drove on in logs."""

    candidate: str
    """Name of its file; empty: the recorded policy alone."""
    logs: tuple[DrivenLog, ...]

    @property
    def exit_status(self) -> int:
        """0: the candidate touches nothing. 1: it does. 2: a log could not be rebuilt, or nothing
        was tried.
        """
        tried = [one for log in self.logs for one in log.tried]
        if not tried or any(log.problem for log in self.logs):
            return 2
        return int(not all(one.is_avoided for one in tried))

    def as_dict(self) -> dict[str, Any]:
        """Everything, for `--json`."""
        return {
            "exit_status": self.exit_status,
            "candidate": self.candidate,
            "logs": [_log_dict(log) for log in self.logs],
        }

    def lines(self) -> list[str]:
        """A text for people."""
        return [line for log in self.logs for line in _log_lines(log, self.candidate)]

    def markdown(self) -> str:
        """The same as a list."""
        return "\n".join(f"- {line.strip()}" for line in self.lines())


def drive_logs(
    paths: tuple[Path, ...],
    policy: Path | None,
    wanted: WantedDrives,
    progress: Callable[[int, int], None] = lambda done, of: None,
) -> DrivenReport:
    """Drive the incidents of logs again; what cannot be rebuilt says why.

    Args:
        paths: the logs.
        policy: the candidate; None: the recorded policy of each.
        wanted: which incidents.
        progress: called with the logs that are done, and all.
    """
    found = []
    for path in paths:
        try:
            found.append(drive_incidents(path, policy, wanted))
        except ReflexarcError as error:
            found.append(DrivenLog(path, problem=str(error)))
        progress(len(found), len(paths))
    return DrivenReport(policy.name if policy else "", tuple(found))


def incident_line(one: Tried, candidate: str) -> str:
    """What became of one incident."""
    what = "contact at tick" if one.is_contact else "tick"
    words = [f"{what} {one.tick}: {_RECORDED} {_control(one)}"]
    if candidate:
        words.append(f"{plain(candidate)} {_outcome(one)}")
    if one.leaves_tick is not None:
        words.append(
            f"the {_RECORDED} leaves its recorded way at tick {one.leaves_tick}, "
            f"{one.leaves_m:.2g} m at most"
        )
    return f"{'; '.join(words)}; from {one.lead_s:.2f} s before"


def _control(one: Tried) -> str:
    if one.recorded_tick is None:
        return f"touches nothing{_room(one.recorded, one)}"
    again = " again" if one.is_contact and one.recorded_tick == one.tick else ""
    return f"touches at tick {one.recorded_tick}{again}"


def _outcome(one: Tried) -> str:
    if one.candidate_tick is None:
        return f"{'avoids it' if one.is_contact else 'touches nothing'}{_room(one.candidate, one)}"
    if one.is_contact and one.candidate_tick > one.tick:
        return f"gets past it and touches at tick {one.candidate_tick}"
    as_well = " as well" if one.candidate_tick == one.recorded_tick else ""
    return f"touches at tick {one.candidate_tick}{as_well}"


def _room(way: DrivenWay, one: Tried) -> str:
    """How near it came; who stands comes near to nothing, so what it drove as well."""
    stood = sum(way.not_asked.values())
    unasked = f", its policy not asked at {stood} ticks" if stood else ""
    driven = f"{way.driven_m:.1f} m driven within {one.driven_s:g} s"
    return f" (nearest {way.nearest_m:.2f} m, {driven}{unasked})"


def _log_lines(log: DrivenLog, candidate: str) -> Iterator[str]:
    name = plain(str(log.log))
    if log.problem:
        yield f"{name}: cannot be rebuilt: {plain(log.problem.removeprefix(f'{log.log}: '))}"
        return
    rebuilt = f": {_rebuilt(log)}" if log.tried else ""
    yield f"{name}: world {plain(log.world)}, seed {log.seed}{rebuilt}"
    for one in log.tried:
        yield f"  {incident_line(one, candidate)}"
    if log.too_late:
        yield (
            f"  {len(log.too_late)} not tried, less than {LEAST_LEAD_S:g} s behind another "
            f"contact: tick{'s' * (len(log.too_late) > 1)} {', '.join(map(str, log.too_late))}"
        )
    if log.tried:
        who = plain(candidate) or _RECORDED
        yield f"  {who} touches nothing at {log.avoided} of {len(log.tried)}"
    else:
        yield "  nothing to try: no contact with enough time before it"


def _rebuilt(log: DrivenLog) -> str:
    if log.off_tick is None:
        return "told the same, the body is where it was"
    return (
        f"the body is put where it was: told the same, it is elsewhere from tick {log.off_tick} "
        f"on, by {log.off_m:.2g} m at most"
    )


def _log_dict(log: DrivenLog) -> dict[str, Any]:
    return {
        "log": str(log.log),
        "problem": log.problem,
        "world": log.world,
        "seed": log.seed,
        "tried": [_tried_dict(one) for one in log.tried],
        "too_late": log.too_late,
        "off_tick": log.off_tick,
        "off_m": log.off_m,
    }


def _tried_dict(one: Tried) -> dict[str, Any]:
    return {
        "tick": one.tick,
        "is_contact": one.is_contact,
        "lead_s": one.lead_s,
        "driven_s": one.driven_s,
        "is_avoided": one.is_avoided,
        "recorded": _way_dict(one.recorded, one.recorded_tick),
        "candidate": _way_dict(one.candidate, one.candidate_tick),
        "leaves_tick": one.leaves_tick,
        "leaves_m": one.leaves_m,
    }


def _way_dict(way: DrivenWay, tick: int | None) -> dict[str, Any]:
    return {
        "contact_tick": tick,
        "nearest_m": way.nearest_m,
        "driven_m": way.driven_m,
        "not_asked": way.not_asked,
    }
