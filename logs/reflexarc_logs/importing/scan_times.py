"""New times for the scans of an imported log, on a clock that begins at zero and never steps back.

Recorded times are often useless: they step back, they repeat because they were printed with only
six digits, or they jump. So scans are spread evenly, or keep their times if those always grow.
"""

from collections import Counter
from typing import Protocol

from reflexarc_runtime.errors import UsageError

MAX_RATE_HZ = 1000.0
MAX_GAP_S = 600.0
"""A robot may rest; between two scans of one drive there are no ten minutes."""

_SECOND_NS = 1_000_000_000


class NewTimes(Protocol):
    """Gives every scan its time, nanoseconds from zero."""

    @property
    def rate_hz(self) -> float:
        """Scans a second; 0 if the file's own times are kept."""
        ...

    def of(self, recorded_ns: int | None, line: int) -> int:
        """The new time of the next scan."""
        ...

    def fault(self) -> str:
        """Why the recorded times cannot be kept; empty if they can."""
        ...


class EvenTimes:
    """Scans at a fixed rate.

    Raises:
        UsageError: a rate that is not in (0, 1000] Hz.
    """

    def __init__(self, rate_hz: float) -> None:
        if not 0.0 < rate_hz <= MAX_RATE_HZ:
            raise UsageError(
                f"--rate: expected recorded, or 0 to {MAX_RATE_HZ:g} Hz, got {rate_hz}"
            )
        self.rate_hz = rate_hz
        self._scans = 0

    def of(self, recorded_ns: int | None, line: int) -> int:
        """See `NewTimes.of`."""
        time_ns = round(self._scans * _SECOND_NS / self.rate_hz)
        self._scans += 1
        return time_ns

    def fault(self) -> str:
        """See `NewTimes.fault`."""
        return ""


class RecordedTimes:
    """The file's own times, the first one being zero. Faults are counted, not corrected."""

    rate_hz = 0.0

    def __init__(self) -> None:
        self._first_ns: int | None = None
        self._last_ns = 0
        self._first_fault = ""
        self._faults: Counter[str] = Counter()
        self._scans = 0

    def of(self, recorded_ns: int | None, line: int) -> int:
        """See `NewTimes.of`; after a fault the result has no meaning."""
        self._scans += 1
        if recorded_ns is None:
            self._note("no time of any calendar", line)
            return 0
        if self._first_ns is None:
            self._first_ns = recorded_ns
        else:
            self._check(recorded_ns - self._last_ns, line)
        self._last_ns = recorded_ns
        return max(0, recorded_ns - self._first_ns)

    def fault(self) -> str:
        """See `NewTimes.fault`."""
        if not self._faults:
            return ""
        counts = ", ".join(f"{count} × {kind}" for kind, count in self._faults.most_common())
        return f"{self._first_fault} (in {self._scans} scans: {counts})"

    def _check(self, step_ns: int, line: int) -> None:
        if step_ns < 0:
            self._note("a step back", line)
        elif step_ns == 0:
            self._note("a repeated time", line)
        elif step_ns > MAX_GAP_S * _SECOND_NS:
            self._note(f"a jump of more than {MAX_GAP_S:g} s", line)

    def _note(self, kind: str, line: int) -> None:
        self._faults[kind] += 1
        self._first_fault = self._first_fault or f"line {line}: {kind}"
