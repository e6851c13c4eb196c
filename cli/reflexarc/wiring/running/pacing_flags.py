"""The flags of a loop's pace, and the pacer that they ask for."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:  # a command line shall not load a contract to show its flags
    from reflexarc_runtime.contract.contract import PolicyContract
    from reflexarc_runtime.loop.inbox import Inbox
    from reflexarc_runtime.loop.pacing.occasions import Rehearses
    from reflexarc_runtime.loop.pacing.pacer import Pacer
    from reflexarc_runtime.messages.topics import Topic

LOCKSTEP = "lockstep"
MOST_SPIN_US = 1000


@dataclass(frozen=True)
class PacingFlags:
    """When a tick begins."""

    pace: Literal["rate", "input"] = "rate"
    """`rate`: at the contract's rate. `input`: when an input arrives, never more often than at that
    rate, and without one half a period after it was due: for the shortest way from sensor to
    command."""
    spin_us: int = 0
    """Stop sleeping so many microseconds before a deadline and watch the clock: a processor's time
    for less lateness."""

    def check(self, *, lockstep: bool) -> None:
        """Check the flags.

        Raises:
            UsageError: no such time, or there is no clock to pace by.
        """
        if not 0 <= self.spin_us <= MOST_SPIN_US:
            raise UsageError(f"--spin-us: expected 0 to {MOST_SPIN_US}, got {self.spin_us}")
        if lockstep and self != PacingFlags():
            raise UsageError(
                "--pace, --spin-us: not with --lockstep, where every input is a tick and no time "
                "passes; leave one of them out"
            )

    def name(self, *, lockstep: bool) -> str:
        """What the log calls the pace."""
        return LOCKSTEP if lockstep else self.pace

    @property
    def longest_wait_periods(self) -> int:
        """How many periods may lie between the beginnings of two ticks."""
        from reflexarc_runtime.loop.pacing.input_pacer import LONGEST_WAIT_PERIODS

        return LONGEST_WAIT_PERIODS if self.pace == "input" else 1

    def pacer(
        self,
        contract: "PolicyContract",
        inbox: "Inbox",
        topic: "Topic",
        rehearse: "Rehearses",
        *,
        lockstep: bool,
    ) -> "Pacer":
        """The pacer of a loop that decides on the messages of a topic.

        Args:
            contract: of the policy.
            inbox: of the loop.
            topic: whose messages begin ticks, where inputs do.
            rehearse: done shortly before a tick is expected.
            lockstep: whether every input is a tick.
        """
        from reflexarc_runtime.loop.clock import MonotonicClock
        from reflexarc_runtime.loop.pacing.input_pacer import InputPacer, may_leave_one_out
        from reflexarc_runtime.loop.pacing.lockstep_pacer import LockstepPacer
        from reflexarc_runtime.loop.pacing.occasions import RehearsingClock
        from reflexarc_runtime.loop.pacing.rate_pacer import RatePacer

        if lockstep:
            return LockstepPacer(inbox)
        clock, rate_hz = MonotonicClock(1000 * self.spin_us), contract.rate_hz
        if self.pace == "rate":
            return RatePacer(rate_hz, RehearsingClock(clock, rehearse), inbox)
        leaves_out = may_leave_one_out(contract)
        return InputPacer(rate_hz, clock, inbox, topic, leaves_out=leaves_out, rehearse=rehearse)
