"""Why a log's test failed, in words that need no other file: when, what was seen, what to type."""

from collections.abc import Iterator, Sequence
from pathlib import Path

from reflexarc_logs.cutting.incident_part import INCIDENT
from reflexarc_logs.judging.amounts import amount, share
from reflexarc_logs.judging.flip_limits import FlipLimits
from reflexarc_logs.judging.judgement import JudgedFlip, LogJudgement
from reflexarc_logs.judging.judgement_text import (
    clearest,
    flip_words,
    incident_words,
    passed_over,
)
from reflexarc_logs.reading.reader import Log
from reflexarc_logs.replaying.asked_policy import attached_policy
from reflexarc_logs.replaying.report import Divergence, ReplayReport
from reflexarc_logs.testing.shades import retina_lines
from reflexarc_logs.testing.tick_moment import TickMoment, lead_words, moment_at
from reflexarc_runtime.errors import ReflexarcError
from reflexarc_runtime.words.shown import plain
from reflexarc_runtime.words.suggestion import pasteable

_SHOWN_FLIPS = 3
_SHOWN_INCIDENTS = 4


def replay_failure(log: Log, path: Path, report: ReplayReport) -> str:
    """Why a log does not replay.

    Args:
        log: the log.
        path: what the reader would type for it.
        report: of its replay.
    """
    lines = [*report.lines(), *_incident(log), *_first_moment(log, report)]
    lines += [f"  next: {pasteable('reflexarc', 'replay', path)}"]
    if report.exit_status == 1:
        lines += [f"  if this is meant: {pasteable('pytest', path, '--reflexarc-update')}"]
    return "\n".join(map(plain, lines))


def judgement_failure(
    log: Log, path: Path, found: LogJudgement, policy: Path, limits: FlipLimits
) -> str:
    """Why a candidate failed on a log.

    Args:
        log: the log.
        path: what the reader would type for it.
        found: on this log.
        policy: the candidate's file, as the reader would type it.
        limits: what it was judged by.
    """
    rate = share(found.flips, found.ticks)
    lines = [
        f"{path}: {policy} is beyond its limits: {'; '.join(found.broken)}",
        f"  {amount(found.flips, 'flip')} at {amount(found.ticks, 'tick')} ({rate}), "
        f"{amount(found.reversals, 'reversal')}; "
        f"limits: {'; '.join(limits.words())}",
        *_incident(log),
    ]
    lines += [f"  {incident_words(one, found)}" for one in found.incidents[:_SHOWN_INCIDENTS]]
    if found.flips:
        lines += [f"  the first flip is at tick {found.first_tick} ({found.first_s:.2f} s)"]
    for flip in clearest(found)[:_SHOWN_FLIPS]:
        lines += _flip_lines(flip, found)
    lines += [f"  {words}" for words in passed_over(found)]
    lines += [f"  note: {note}" for note in found.notes]
    command = pasteable("reflexarc", "replay", path, "--policy", policy, *_flags(limits))
    return "\n".join(map(plain, [*lines, f"  next: {command}"]))


def _flip_lines(flip: JudgedFlip, found: LogJudgement) -> Iterator[str]:
    yield f"  {flip_words(flip, found)}"
    for line in retina_lines(flip.retina, found.retina_shape):
        yield f"    {line}"


def _flags(limits: FlipLimits) -> list[str]:
    """The limits as they are typed."""
    flags = {
        "--max-flips": limits.max_flips,
        "--max-reversals": "" if limits.max_reversals is None else str(limits.max_reversals),
        "--margin": repr(limits.margin) if limits.margin else "",
        "--from": limits.since,
        "--to": limits.until,
    }
    return [word for flag, value in flags.items() if value for word in (flag, value)]


def _incident(log: Log) -> Iterator[str]:
    """What a part of a log says that it shows."""
    note = log.metadata.get(INCIDENT, {}).get("note", "")
    if note:
        yield f"  it shows {note}"


def _first_moment(log: Log, report: ReplayReport) -> Iterator[str]:
    """The first tick that differs, as it was."""
    first = _first(report)
    if first is None:
        return
    try:
        moment = moment_at(log, first.tick, attached_policy(log, report.backend))
    except ReflexarcError:
        return  # what is wrong with the policy stands in the report
    if moment is not None:
        yield f"  tick {moment.tick} ({moment.time_s:.2f} s) saw"
        yield from (f"    {line}" for line in moment.retina or ("nothing: it was not asked",))
        yield from _leads(moment, report.actions)


def _first(report: ReplayReport) -> Divergence | None:
    firsts = [level.first for level in report.levels]
    firsts += [commands.first for commands in report.commands]
    return min((one for one in firsts if one is not None), key=lambda d: d.tick, default=None)


def _leads(moment: TickMoment, actions: Sequence[str]) -> Iterator[str]:
    if moment.recorded_q_values:
        now = "" if moment.q_values is None else f"; now {lead_words(moment.q_values, actions)}"
        yield f"    recorded: {lead_words(moment.recorded_q_values, actions)}{now}"
