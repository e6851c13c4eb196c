"""What was measured of a loop's punctuality, in words."""

from collections.abc import Iterator

from reflexarc.doctoring.check_row import CheckRow, Health, unknown, well
from reflexarc.doctoring.lateness_trial import NoPunctuality, Punctuality
from reflexarc.terminal.output import microseconds
from reflexarc_runtime.messages.spread import Spread

AS_C_NS = 50_000
"""A loop that is later than C by more than this at the 99th percentile is worth a word."""


def lateness_rows(found: Punctuality | NoPunctuality) -> Iterator[CheckRow]:
    """One for waking, one for C's beside it, one for the tick."""
    name = f"waking, {found.scheduling}"
    if isinstance(found, NoPunctuality):
        yield unknown(name, found.why)
        return
    yield judge_waking(name, found)
    if found.beside is not None:
        yield well("  C beside it", f"{spread_in_words(found.beside)}, {found.beside_by}")
    if found.tick is not None:
        skipped = f", slots skipped: {found.skipped}" if found.skipped else ""
        yield well("  waking to command", spread_in_words(found.tick) + skipped)


def judge_waking(name: str, found: Punctuality) -> CheckRow:
    """How late it woke, beside C."""
    words, beside = spread_in_words(found.lateness), found.beside
    if beside is None or found.lateness.p99_ns <= beside.p99_ns + AS_C_NS:
        return well(name, words)
    why = "later than C by more than 50 µs at the 99th percentile, in turns, not at one time"
    return CheckRow(name, Health.MIND, words, why, "measure again: --seconds 30")


def spread_in_words(spread: Spread) -> str:
    """Percentiles for people."""
    named = {
        "p50": spread.p50_ns,
        "p99": spread.p99_ns,
        "p99.9": spread.p999_ns,
        "max": spread.max_ns,
    }
    return ", ".join(f"{name} {microseconds(ns)}" for name, ns in named.items())
