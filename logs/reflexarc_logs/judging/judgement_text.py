"""What was found on one log in words: a row of a table, and lines."""

from collections.abc import Iterator

from reflexarc_logs.judging.amounts import amount, share
from reflexarc_logs.judging.judgement import IncidentAnswer, JudgedFlip, LogJudgement
from reflexarc_logs.judging.text_table import quoted
from reflexarc_runtime.words.shown import plain

SHOWN_FLIPS = 5
SHOWN_INCIDENTS = 8

HEAD = ("log", "ticks", "flips", "rate", "reversals", "largest margin", "first", "verdict")


def flip_words(one: JudgedFlip, log: LogJudgement) -> str:
    """A flip on one line."""
    names = plain(f"{log.action(one.recorded)} → {log.action(one.candidate)}")
    kind = ", reversed" * one.is_reversal
    margins = f"margin {one.margin:.3g}, the candidate's {one.candidate_margin:.3g}"
    return f"tick {one.tick} ({one.time_s:.2f} s): {names}{kind}; {margins}"


def incident_words(one: IncidentAnswer, log: LogJudgement) -> str:
    """An incident and the answer on one line."""
    said = f" ({plain(one.words)})" if one.words else ""
    what = f"{one.kind} at tick {one.tick} ({one.time_s:.2f} s){said}"
    if one.asked_tick < 0:
        return f"{what}: no policy was asked before it"
    at = "" if one.asked_tick == one.tick else f" at tick {one.asked_tick}, the last one asked"
    recorded, candidate = plain(log.action(one.recorded)), plain(log.action(one.candidate))
    if one.recorded == one.candidate:
        return f"{what}: both prefer {recorded}{at}"
    return f"{what}: {recorded} was preferred, the candidate prefers {candidate}{at}"


def row(one: LogJudgement) -> tuple[str, ...]:
    """A row under `HEAD`."""
    if one.problem:
        return (plain(one.log), *["–"] * 6, f"{one.verdict}: {plain(one.problem)}")
    first = f"tick {one.first_tick} ({one.first_s:.2f} s)" if one.flips else "–"
    margin = f"{one.largest_margin:.3g}" if one.flips else "–"
    counts = str(one.ticks), str(one.flips), share(one.flips, one.ticks), str(one.reversals)
    reason = f": {'; '.join(one.broken)}" if one.broken else ""
    return (plain(one.log), *counts, margin, first, f"{one.verdict}{reason}")


def has_details(one: LogJudgement) -> bool:
    """Whether there is more to say than a row."""
    passed_over = one.below_margin or one.rounding or one.warming_up
    return bool(one.shown_flips or one.incidents or one.notes or passed_over)


def log_lines(one: LogJudgement) -> Iterator[str]:
    """More than a row: what happened, the flips of the largest margins, what did not count."""
    yield f"{plain(one.log)}:"
    for words in passed_over(one):
        yield f"  {words}"
    for incident in one.incidents[:SHOWN_INCIDENTS]:
        yield f"  {incident_words(incident, one)}"
    hidden = one.more_incidents + max(0, len(one.incidents) - SHOWN_INCIDENTS)
    if hidden:
        yield f"  … and {amount(hidden, 'incident')} more"
    for flip in clearest(one)[:SHOWN_FLIPS]:
        yield f"  {flip_words(flip, one)}"
    if one.flips > SHOWN_FLIPS:
        yield f"  … and {amount(one.flips - SHOWN_FLIPS, 'flip')} more, of no larger margin"
    for note in one.notes:
        yield f"  note: {note}"


def clearest(one: LogJudgement) -> list[JudgedFlip]:
    """The flips that are kept, those of the largest margins first."""
    return sorted(one.shown_flips, key=lambda flip: (-flip.margin, flip.tick))


def passed_over(one: LogJudgement) -> Iterator[str]:
    """What did not count."""
    if one.below_margin:
        yield f"not counted: {amount(one.below_margin, 'flip')} of smaller margins"
    if one.rounding:
        yield f"not counted: {amount(one.rounding, 'flip')} of rounding: two backends may differ so"
    if one.warming_up:
        yield f"not counted: {amount(one.warming_up, 'tick')} in which its memory warms up"


def markdown_row(one: LogJudgement) -> tuple[str, ...]:
    """A row in which words of others are code: they may be anything."""
    name, *numbers, verdict = row(one)
    if one.problem:
        verdict = f"{one.verdict}: {quoted(plain(one.problem))}"
    return (quoted(name), *numbers, verdict)
