"""A log in words and tables: the run, where it was driven, and its streams."""

from datetime import UTC, datetime
from math import isfinite
from pathlib import Path

from rich import box
from rich.console import Group
from rich.table import Table

from reflexarc.terminal.body_words import body_words
from reflexarc.terminal.output import facts, kibibytes, plain
from reflexarc_logs.container.run_info import RunInfo
from reflexarc_logs.reading.candidates import CandidatesSeen
from reflexarc_logs.reading.summary import ForeignSummary, LogSummary, TopicSummary
from reflexarc_runtime.contract.body_limits import BodyLimits
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.messages.body_info import BodyInfo

SHOWN = 12
"""Characters of a hash that people are shown."""
MOST_SERVED = 6
"""Names that one line has room for; the JSON has all."""
NOT_RECORDED = "not recorded"


def describe_log(path: Path, summary: LogSummary) -> Group:
    """All that a person should know of a log before it is replayed."""
    run = summary.run
    state = "complete" if summary.complete else "cut off: see `reflexarc recover`"
    rows = {
        "log": f"{plain(str(path))} ({state})",
        "run": f"{plain(run.run_id)}, {run.recorded_by} on {plain(run.host)}, {run.clock} clock"
        f"{_pace(summary)}",
        "policy": plain(summary.policy_hash) or "none attached",
        **_candidates(summary.candidates),
        "rules": _rules(run),
        **_place(summary.body),
        **_watched(summary),
        "size": f"{kibibytes(summary.bytes)}, {summary.messages} messages, "
        f"{summary.duration_s:.1f} s",
    }
    if summary.by_index:
        rows["counted"] = "by its index, which does not say how large the payloads are"
    return Group(facts(rows), _topics(summary.topics))


def describe_foreign(path: Path, summary: ForeignSummary) -> Group:
    """What can be said of a log that reflexarc did not record."""
    state = "complete" if summary.complete else f"not whole: {plain(summary.damage)}"
    rows = {
        "log": f"{plain(str(path))} ({state})",
        "of": "another system: it is not a log of reflexarc, and cannot be replayed or played",
        "profile": plain(summary.profile) or "none",
        "written by": plain(summary.library) or NOT_RECORDED,
        "begins": _wall_time(summary.first_ns) if summary.messages else NOT_RECORDED,
        "size": f"{kibibytes(summary.bytes)}, {summary.messages} messages, "
        f"{summary.duration_s:.1f} s",
        "attachments": ", ".join(map(plain, summary.attachments)) or "none",
        "metadata": ", ".join(map(plain, summary.metadata)) or "none",
    }
    return Group(facts(rows), _topics(summary.topics))


def _candidates(seen: CandidatesSeen | None) -> dict[str, str]:
    """Who served beside the first policy, and who watched."""
    said: dict[str, str] = {}
    if seen is not None and len(seen.served) > 1:
        names = [plain(name[:SHOWN]) for name in seen.served]
        more = f" and {len(names) - MOST_SERVED} more" if len(names) > MOST_SERVED else ""
        said["served"] = f"{', '.join(names[:MOST_SERVED])}{more} (by its keyframes)"
    if seen is not None and seen.compared:
        faults = f", {seen.faults} faults" * bool(seen.faults)
        words = f"{seen.compared} ticks, {seen.different} otherwise{faults}"
        said["shadow"] = f"{plain(seen.shadow_hash[:SHOWN])}: {words}"
    return said


def _wall_time(time_ns: int) -> str:
    """A time since 1970 as a date, if it can be one."""
    try:
        return datetime.fromtimestamp(time_ns // 10**9, UTC).isoformat(" ", "seconds")
    except (OverflowError, ValueError, OSError):
        return f"at {time_ns} ns"


def _rules(run: RunInfo) -> str:
    """By which rules the controller decided; what is imported was decided by none."""
    return "none" if run.recorded_by == "import" else f"version {run.rules} of the controller's"


def _pace(summary: LogSummary) -> str:
    """When a tick began, where that says more than the clock."""
    return ", a tick at an input" if summary.pace == "input" else ""


def _place(body: BodyInfo | None) -> dict[str, str]:
    """In which world a body drove, and how fast it could."""
    if body is None:
        return {"world": NOT_RECORDED}
    limits = {"limits": _limits(body.limits)}
    if not body.step_s:
        return {"world": "none: the body is not simulated", **limits}
    where = f"{plain(body.world)}, seed {body.seed}, robot number {body.number}"
    return {"world": f"{where}, steps of {body.step_s:g} s", **limits}


def _limits(limits: BodyLimits | None) -> str:
    if limits is None:
        return "none of the body's own"
    said = (
        f"{limits.linear_mps:g} m/s ahead, {limits.lateral_mps:g} m/s sideways, "
        f"{limits.angular_radps:g} rad/s"
    )
    if isfinite(limits.acceleration_mps2):
        said += f", faster by at most {limits.acceleration_mps2:g} m/s²"
    if isfinite(limits.valid_for_s):
        said += f", commands for at most {limits.valid_for_s:g} s"
    return said


def _watched(summary: LogSummary) -> dict[str, str]:
    """What looked at the decisions and at the loop, if anything did."""
    if summary.run.recorded_by == "import":
        return {}
    guard = summary.guard
    return {
        "guard": "none" if guard is None else _guard(guard),
        "watchdog": plain(summary.watchdog) or NOT_RECORDED,
        **({"real time": plain(summary.realtime)} if summary.realtime else {}),
    }


def _guard(guard: GuardSettings) -> str:
    body = body_words(guard.footprint, guard.delay_s, guard.deceleration_mps2)
    slower = "slower or other actions" if guard.may_slow else "other actions"
    return (
        f"keeps {guard.margin_m:g} m, prefers what is free {guard.evade_s:g} s longer; {slower}; "
        f"for {body.outline} that obeys {body.obeys} and stops {body.stops}"
    )


def _topics(topics: tuple[TopicSummary, ...]) -> Table:
    # Without lines between the columns, so that the names of messages are whole in 80 characters.
    table = Table(box=box.SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for name in ("topic", "message"):
        table.add_column(name)
    for name in ("count", "senders", "rate", "payload"):
        table.add_column(name, justify="right")
    for topic in topics:
        table.add_row(
            plain(topic.topic),
            plain(topic.schema),
            str(topic.messages),
            str(topic.senders or ""),
            f"{topic.rate_hz:.1f} Hz" if topic.rate_hz else "",
            "" if topic.payload_bytes is None else kibibytes(topic.payload_bytes),
        )
    return table
