"""Wires between the modules of a subsumption architecture: suppression and inhibition.

Source: R. A. Brooks, *A robust layered control system for a mobile robot*, IEEE J. Robotics and
Automation 2(1), 1986. A higher module taps a line of a lower one, which knows nothing of it:

- a suppressor replaces what the line carries: for its time constant after each message from above
  the line carries that message, and its own are lost;
- an inhibitor blanks it: for its time constant after each message from above the line is silent.

A message at time t holds the wire over [t, t + τ). The time constant is in seconds; the state of a
wire is part of its owner's memory: the decisions that it is still held, and for a suppressor the
message that it holds.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from reflexarc_baselines.baseline import Floats
from reflexarc_runtime.arrays import Mask, Memories
from reflexarc_runtime.choice import slots_of


@dataclass(frozen=True)
class Messages:
    """What a line carries in one decision, for each agent."""

    values: Floats
    """Messages, 0 where none is sent: (n,)."""
    is_sent: Mask
    """(n,)."""


@dataclass(frozen=True)
class Suppressor:
    """Replaces what a line carries."""

    SIZE: ClassVar[int] = 2
    """Values of its state."""

    time_constant_s: float
    period_s: float
    """Time between two decisions."""

    def passed(
        self, line: Messages, from_above: Messages, state: Memories
    ) -> tuple[Messages, Memories]:
        """What arrives at the end of the line, and the wire's next state.

        Args:
            line: what the lower module sends.
            from_above: what the higher module sends.
            state: (n, 2), zeros at the start.
        """
        left = _left(from_above.is_sent, state[:, 0], self.time_constant_s, self.period_s)
        message = np.where(from_above.is_sent, from_above.values, state[:, 1])
        is_held = left > 0.0
        arrives = Messages(np.where(is_held, message, line.values), is_held | line.is_sent)
        return arrives, _state(left, np.where(is_held, message, 0.0))


@dataclass(frozen=True)
class Inhibitor:
    """Blanks what a line carries."""

    SIZE: ClassVar[int] = 1

    time_constant_s: float
    period_s: float

    def passed(
        self, line: Messages, from_above: Mask, state: Memories
    ) -> tuple[Messages, Memories]:
        """What arrives at the end of the line, and the wire's next state (n, 1).

        Args:
            line: what the lower module sends.
            from_above: where the higher module inhibits: (n,).
            state: (n, 1), zeros at the start.
        """
        left = _left(from_above, state[:, 0], self.time_constant_s, self.period_s)
        passes = line.is_sent & (left <= 0.0)
        return Messages(np.where(passes, line.values, np.float32(0.0)), passes), _state(left)


def _left(is_sent: Mask, before: Floats, time_constant_s: float, period_s: float) -> Floats:
    """Decisions, this one among them, for which the wire is held."""
    slots = slots_of(time_constant_s, 1.0 / period_s)
    left: Floats = np.where(is_sent, np.float32(slots), np.maximum(before - 1.0, 0.0))
    return left


def _state(*columns: Floats) -> Memories:
    return np.stack(columns, axis=1).astype(np.float32)
