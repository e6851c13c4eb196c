"""How much a candidate may differ from what was recorded, and where that is counted."""

import re
from dataclasses import dataclass
from fractions import Fraction

from reflexarc_logs.judging.amounts import amount, share
from reflexarc_logs.reading.tick_word import TickWord, tick_word
from reflexarc_runtime.errors import UsageError

_COUNT = re.compile(r"[0-9]{1,18}")
_SHARE = re.compile(r"([0-9]{1,3}(?:\.[0-9]{1,12})?) ?%")


@dataclass(frozen=True)
class FlipLimits:
    """Limits for one log; each log is judged by itself."""

    max_flips: str = ""
    """How many flips at most: "12", or "5%" of the ticks that count. Empty: none; but any number
    where `max_reversals` is set."""
    max_reversals: int | None = None
    """How many flips to the opposite action at most."""
    margin: float = 0.0
    """Flips whose recorded margin is below it do not count."""
    since: str = ""
    """From where ticks count: a tick's number ("120"), or seconds since the log's first tick
    ("2.4s"); empty: from the first one on."""
    until: str = ""
    """The same for the tick before which counting ends."""

    def __post_init__(self) -> None:
        """Check what it was given.

        Raises:
            UsageError: a word that is none, or a number out of place.
        """
        if self.max_flips and not _allowed(self.max_flips):
            raise UsageError(
                "--max-flips: expected a count or a share, as 12 or 5%, got "
                f"{self.max_flips[:20]!r}"
            )
        if self.max_reversals is not None and self.max_reversals < 0:
            raise UsageError(f"--max-reversals: expected 0 or more, got {self.max_reversals}")
        if not 0.0 <= self.margin < float("inf"):
            raise UsageError(f"--margin: expected a number of 0 or more, got {self.margin}")
        window = self.window
        if _is_empty(window):
            raise UsageError(
                f"--from {self.since} --to {self.until}: expected a place and a later one"
            )

    @property
    def are_set(self) -> bool:
        """Whether any limit was asked for."""
        return self != FlipLimits()

    @property
    def window(self) -> tuple[TickWord | None, TickWord | None]:
        """From where to where ticks count."""
        since = tick_word("--from", self.since) if self.since else None
        return since, tick_word("--to", self.until) if self.until else None

    def exceeded(self, flips: int, reversals: int, ticks: int) -> tuple[str, ...]:
        """The limits that are exceeded, in words.

        Args:
            flips: those that count.
            reversals: those among them.
            ticks: those that count.
        """
        found = []
        allowed = _allowed(self._flips_word)
        if allowed is not None:
            most = allowed[0] * ticks if allowed[1] else allowed[0]
            if flips > most:
                rate = f" ({share(flips, ticks)})"
                found.append(f"{amount(flips, 'flip')}{rate} of at most {self._flips_word}")
        if self.max_reversals is not None and reversals > self.max_reversals:
            found.append(f"{amount(reversals, 'reversal')} of at most {self.max_reversals}")
        return tuple(found)

    def words(self) -> tuple[str, ...]:
        """What is judged by, each in words."""
        found = [f"at most {self._flips_word} flips"] if self._flips_word else []
        if self.max_reversals is not None:
            found.append(f"at most {self.max_reversals} reversals")
        if self.margin:
            found.append(f"flips with a margin below {self.margin:g} do not count")
        if self.since:
            found.append(f"from {_placed(self.since)} on")
        if self.until:
            found.append(f"before {_placed(self.until)}")
        return tuple(found)

    @property
    def _flips_word(self) -> str:
        return self.max_flips or ("0" if self.max_reversals is None else "")


def _allowed(word: str) -> tuple[Fraction, bool] | None:
    """A number, and whether it is a share of the ticks; None: it is neither."""
    if _COUNT.fullmatch(word):
        return Fraction(word), False
    found = _SHARE.fullmatch(word)
    if found is None or Fraction(found[1]) > 100:  # more than all of them limits nothing
        return None
    return Fraction(found[1]) / 100, True


def _is_empty(window: tuple[TickWord | None, TickWord | None]) -> bool:
    since, until = window
    if since is None or until is None:
        return False
    if since.index is not None and until.index is not None:
        return since.index >= until.index
    if since.after_ns is not None and until.after_ns is not None:
        return since.after_ns >= until.after_ns
    return False


def _placed(word: str) -> str:
    return f"{word[:-1]} s" if word.endswith("s") else f"tick {word}"
