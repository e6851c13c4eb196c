"""How a sender's clock runs against the one that a log was recorded by.

The delay of a message is its log time minus the time at which it was sent: the way that it took,
plus a constant, as the two clocks begin anywhere. The way varies, but its least over a window of
half a second and five messages hardly does, so the course of these least delays is that of the
clocks. Their slope is the drift: the median of all slopes over a sixth of the log, which a step or
two do not move. A step is a jump that lasts: all windows of the seconds before it lie on one side
of all those behind it. A network that stalls lets go of what it held, so it is none.
"""

from dataclasses import dataclass, field
from statistics import median

WINDOW_NS = 500_000_000
WINDOW_MESSAGES = 5
LEAST_STEP_NS = 20_000_000
LEAST_WINDOWS = 8
"""Fewer say nothing about drift."""
MOST_WINDOWS = 4096
"""Of more, every two become one: memory does not grow with the log."""
_SIDE = 8
"""Windows on either side of a step; near an end of the log fewer will do."""
_LEAST_SIDE = 3


@dataclass(frozen=True, slots=True)
class SenderStep:
    """A sender's clock that was set."""

    at_ns: int
    """Log time."""
    step_ns: float
    """Forward is positive."""


@dataclass(slots=True)
class DelayCourse:
    """The least delays of a stream, window by window."""

    _windows: list[tuple[int, int]] = field(default_factory=list)
    """Least delay, and the log time at which it was; the last one may still be open."""
    _window_ns: int = WINDOW_NS
    _begun_ns: int = 0
    _messages: int = 0
    """In the open window."""

    def add(self, log_ns: int, sent_ns: int) -> None:
        """Take a message, in the order of arrival."""
        found = log_ns - sent_ns, log_ns
        is_over = self._messages >= WINDOW_MESSAGES and log_ns - self._begun_ns >= self._window_ns
        if is_over or not self._windows:
            self._windows.append(found)
            self._begun_ns, self._messages = log_ns, 0
            self._halve()
        elif found < self._windows[-1]:
            self._windows[-1] = found
        self._messages += 1

    def drift(self) -> float | None:
        """Seconds that the sender's clock gains a second; None: too short to tell."""
        windows = self._whole()
        if len(windows) < LEAST_WINDOWS:
            return None
        lag = max(2, len(windows) // 6)
        pairs = zip(windows, windows[lag:], strict=False)
        return median((a - b) / (at_b - at_a) for (a, at_a), (b, at_b) in pairs if at_b > at_a)

    def drifted_ns(self) -> float:
        """How far the sender's clock has drifted over all."""
        drift, windows = self.drift(), self._whole()
        return 0.0 if drift is None else drift * (windows[-1][1] - windows[0][1])

    def steps(self) -> list[SenderStep]:
        """Where the sender's clock was set."""
        drift, windows = self.drift() or 0.0, self._whole()
        first_ns = windows[0][1] if windows else 0
        level = [-delay - drift * (at - first_ns) for delay, at in windows]
        sides = range(_LEAST_SIDE, len(level) - _LEAST_SIDE + 1)
        return [SenderStep(windows[k][1], jump) for k in sides if (jump := _jump(level, k))]

    def _whole(self) -> list[tuple[int, int]]:
        """The windows, without one that has just begun."""
        return self._windows if self._messages >= WINDOW_MESSAGES else self._windows[:-1]

    def _halve(self) -> None:
        if len(self._windows) > MOST_WINDOWS:
            pairs = zip(self._windows[:-1:2], self._windows[1:-1:2], strict=True)
            self._windows = [*map(min, pairs), self._windows[-1]]
            self._window_ns *= 2


def _jump(level: list[float], k: int) -> float:
    """The jump in front of window k: by how much both sides are apart; 0: there is none."""
    before, after = level[max(0, k - _SIDE) : k], level[k : k + _SIDE]
    if abs(level[k] - level[k - 1]) <= LEAST_STEP_NS:
        return 0.0
    up, down = min(after) - max(before), min(before) - max(after)
    jump = up if up > 0 else -down
    return jump if max(up, down) > LEAST_STEP_NS else 0.0
