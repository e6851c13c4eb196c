"""The flags of a loop's watchdog, and the watchdog that they ask for."""

from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from typing import TYPE_CHECKING

from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from collections.abc import Callable

    from reflexarc_runtime.bus import Bus
    from reflexarc_runtime.contract.contract import PolicyContract
    from reflexarc_runtime.loop.inbox import Inbox
    from reflexarc_runtime.loop.loop_watchdog import Budget
    from reflexarc_runtime.loop.watch import Watch

LEAST_PROCESS_S = 0.5
"""The kernel ends no process sooner: machines oversleep by tens of milliseconds."""


@dataclass(frozen=True)
class Watching:
    """How late the loop may be, and whether anyone looks. In lockstep nobody does."""

    watchdog_ms: float | None = None
    """How late a tick may be before the watchdog stops the body in its place; by default half of
    the age at which an input is stale."""
    no_watchdog: bool = False
    """Start no watchdog: a loop that hangs is noticed by the body alone."""

    def check(self) -> None:
        """Check the flags.

        Raises:
            UsageError: no such budget.
        """
        if self.watchdog_ms is not None and not 1.0 <= self.watchdog_ms <= 10_000.0:
            raise UsageError(f"--watchdog-ms: expected 1 to 10000, got {self.watchdog_ms:g}")

    def watch(
        self,
        bus: "Bus",
        inbox: "Inbox",
        contract: "PolicyContract",
        *,
        robot: str,
        run_id: str,
        lockstep: bool,
        serving: "Callable[[], str]",
        end_decision: "Callable[[], None]",
        longest_wait_periods: int = 1,
    ) -> "AbstractContextManager[Watch]":
        """Announce the runtime, and watch its loop inside this context.

        Args:
            bus: an open session.
            inbox: of the loop.
            contract: of its policies, in what they have in common.
            robot: the robot's name.
            run_id: of the run.
            lockstep: whether no time passes.
            longest_wait_periods: how many periods may lie between two ticks of a punctual loop.
            serving: the hash of the policy that decides.
            end_decision: ends a decision that is going on, if it can be ended.
        """
        from reflexarc_runtime.loop.clock import MonotonicClock
        from reflexarc_runtime.loop.loop_watchdog import LoopWatchdog
        from reflexarc_runtime.loop.stand_in import OwnOutlets, StandIn
        from reflexarc_runtime.loop.watch import NoWatch
        from reflexarc_runtime.messages.topics import COMMAND, OVERRUN, RUNTIME_NODE, STATUS

        announcement = bus.announce(RUNTIME_NODE)
        if self.no_watchdog or lockstep:
            return nullcontext(NoWatch())
        stand_in = StandIn(
            OwnOutlets(bus.publisher(COMMAND), bus.publisher(OVERRUN), bus.publisher(STATUS)),
            contract.safe_command,
            robot=robot,
            sender=bus.sender,
            run_id=run_id,
            policy_hash=serving,
        )
        return LoopWatchdog(
            self.budget(contract, longest_wait_periods),
            MonotonicClock().now_ns,
            inbox,
            stand_in,
            announcement,
            end_decision,
        )

    def budget(self, contract: "PolicyContract", longest_wait_periods: int = 1) -> "Budget":
        """How late a loop of this contract may be.

        Args:
            contract: of the policy.
            longest_wait_periods: how many periods may lie between two ticks of a punctual loop.
        """
        from reflexarc_runtime.loop.loop_watchdog import Budget

        tick_s = contract.max_input_age_s / 2
        if self.watchdog_ms is not None:
            tick_s = self.watchdog_ms / 1e3
        period_s = longest_wait_periods / contract.rate_hz
        process_s = period_s + max(LEAST_PROCESS_S, 2 * contract.max_input_age_s, 4 * tick_s)
        return Budget(round(tick_s * 1e9), round(period_s * 1e9), process_s)
