"""How a sender's clock runs against the one that a log was recorded by.

The delay of a message is its log time minus the time at which it was sent: the way that it took,
plus a constant, as the two clocks begin anywhere. The way varies, but its least over a window of
two seconds hardly does, so the course of these least delays is that of the clocks: its slope is the
drift, the median of all slopes from window to window, which a step does not move; a step is a jump
that two windows before and two behind it agree on, so that a network that stalls is none.
"""

from dataclasses import dataclass, field
from statistics import median

WINDOW_NS = 2_000_000_000
LEAST_STEP_NS = 20_000_000
LEAST_WINDOWS = 5
"""Fewer say nothing about drift."""


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
    """Log time, least delay."""
    _ends_ns: int = -1
    _least: tuple[int, int] = (0, 0)

    def add(self, log_ns: int, sent_ns: int) -> None:
        """Take a message, in the order of arrival."""
        delay_ns = log_ns - sent_ns
        if log_ns >= self._ends_ns:
            if self._ends_ns >= 0:
                self._windows.append(self._least)
            self._ends_ns, self._least = log_ns + WINDOW_NS, (log_ns, delay_ns)
        elif delay_ns < self._least[1]:
            self._least = log_ns, delay_ns

    def drift(self) -> float | None:
        """Seconds that the sender's clock gains a second; None: too short to tell."""
        slopes = [
            (before[1] - after[1]) / (after[0] - before[0])
            for before, after in zip(self._windows, self._windows[1:], strict=False)
            if after[0] > before[0]
        ]
        return median(slopes) if len(slopes) >= LEAST_WINDOWS - 1 else None

    def drifted_ns(self) -> float:
        """How far the sender's clock has drifted over all."""
        drift = self.drift()
        return 0.0 if drift is None else drift * (self._windows[-1][0] - self._windows[0][0])

    def steps(self) -> list[SenderStep]:
        """Where the sender's clock was set."""
        drift = self.drift() or 0.0
        level = [(at, -delay - drift * at) for at, delay in self._windows]
        found = [self._step(level, k) for k in range(2, len(level) - 1)]
        return [step for step in found if abs(step.step_ns) > LEAST_STEP_NS]

    def _step(self, level: list[tuple[int, float]], k: int) -> SenderStep:
        """The jump in front of window k: the least that both sides agree on."""
        before, after = [v for _, v in level[k - 2 : k]], [v for _, v in level[k : k + 2]]
        up, down = min(after) - max(before), min(before) - max(after)
        jump = up if up > 0 else -down if down > 0 else 0.0
        alone = abs(level[k][1] - level[k - 1][1]) > LEAST_STEP_NS
        return SenderStep(level[k][0], jump if alone else 0.0)
