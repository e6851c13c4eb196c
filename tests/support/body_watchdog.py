"""The watchdog of the fault campaigns' body: whether a command may still be obeyed.

It is the rule of a command's validity and no more: no lease, no arming, no limits. So what the
campaigns measure is that rule alone, in the plainest words; the bodies that are shipped have the
gate.

A command repeats the source time of the input that led to it, which the body itself had set. So
the body compares only times of its own clock, and silence of any cause ends in a stop.
"""

from dataclasses import dataclass, replace

from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.decision import Command


@dataclass(frozen=True, slots=True)
class Watchdog:
    """The last command that came, and the safe action for when it no longer holds."""

    safe: Action
    last: Command | None = None

    def heard(self, command: Command) -> "Watchdog":
        """The watchdog after another command."""
        return replace(self, last=command)

    def obeyed(self, now_ns: int) -> Command | None:
        """The command to obey now; None: execute the safe action.

        A drive command holds while now − its source time < `valid_for_ns`. A source time in the
        future cannot be of this body's clock: such a command is not obeyed.
        """
        if self.last is None or self.last.source_time_ns is None:
            return self.last
        age_ns = now_ns - self.last.source_time_ns
        return self.last if 0 <= age_ns < self.last.valid_for_ns else None
