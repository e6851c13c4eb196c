"""Ticks when an input arrives, within a rate, and at a deadline where none does.

The generic cell rate algorithm (ITU-T I.371, virtual scheduling) with a period P and a tolerance of
P/2, which also has a latest time. Let T be the nominal time of the next tick:

- from T − P/2 on a tick is due as soon as an input arrives; then T becomes max(arrival, T) + P;
- at T + P/2 it is due without one; then T becomes T + P.

A tick that begins later than it was due does not move T, as at absolute deadlines; but by whole
periods that have passed meanwhile, which are left out: never a burst.

So n ticks take n − 1 periods at least, but for the tolerance: from the beginning on no more ticks
than the rate allows and one half, in any stretch no more than two beyond it. A jitter of the
arrivals of up to P/2 costs no latency.

**An input that arrives before T − P/2** begins no tick by itself where its successor may: the tick
begins at the next input, which is newer. Otherwise a sensor that is quicker than the rate by a
thousandth would have its pictures wait, each a little longer than the one before, up to a whole
period: two clocks are never equal. Where its body would not live through the period that is then
left out, such an input begins a tick at T − P/2.

What stops a loop, or lets it go on, begins a tick as an input does; one that came too early, at
T − P/2.

**Slots.** The slot of a tick is the whole number of periods from the beginning to its nominal time.
Nominal times lie a period apart at least, so slots strictly increase; and they count time, as a
hold needs it, also where a sensor is slower than the rate.
"""

from collections.abc import Callable

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.loop.bell import new_bell
from reflexarc_runtime.loop.clock import Clock
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.pacing.expected_arrival import ExpectedArrival
from reflexarc_runtime.loop.pacing.occasions import Occasions, Rehearses
from reflexarc_runtime.loop.pacing.pacer import PATIENCE_NS, Wakeup, came_near
from reflexarc_runtime.messages.topics import Topic

_PERIODS_AN_INPUT_MUST_LAST = 3
"""Two periods may lie between two ticks, and messages are on their way for less than one."""

LONGEST_WAIT_PERIODS = 2
"""From the beginning of one tick to that of the next: half a period early, half a period late."""


def may_leave_one_out(contract: PolicyContract) -> bool:
    """Whether a body obeys a command for so long that a period without one does not stop it."""
    return contract.max_input_age_s * contract.rate_hz >= _PERIODS_AN_INPUT_MUST_LAST


class InputPacer:
    """At the arrival of an input, never more often than at a rate.

    Args:
        rate_hz: of the contract.
        clock: what deadlines are on.
        inbox: where inputs arrive; nobody else may arm its bell.
        topic: what an input is.
        leaves_out: whether an input that came too early leaves the tick to its successor.
        rehearse: done shortly before an input is expected, if none came meanwhile.
    """

    def __init__(
        self,
        rate_hz: float,
        clock: Clock,
        inbox: Inbox,
        topic: Topic,
        *,
        leaves_out: bool = True,
        rehearse: Rehearses | None = None,
    ) -> None:
        self._clock = clock
        self._expected = ExpectedArrival()
        self._occasions = None if rehearse is None else Occasions(clock.now_ns, rehearse)
        self._inbox = inbox
        self._bell = new_bell()
        inbox.ring_for(topic, self._bell)
        self._leaves_out = leaves_out
        self._period_ns = round(1e9 / rate_hz)
        self._half_ns = self._period_ns // 2
        self._start_ns: int | None = None
        self._nominal_ns = 0
        """Of the next tick."""
        self._slot = 0

    def wait(self, should_stop: Callable[[], bool]) -> Wakeup | None:
        """See `Pacer.wait`."""
        if self._start_ns is None:
            self._start_ns = self._clock.now_ns()
            self._nominal_ns = self._start_ns + self._period_ns
        self._learn()
        earliest_ns = self._nominal_ns - self._half_ns
        self._inbox.arm(earliest_ns if self._leaves_out else 0)
        is_rung = self._is_rung_early(should_stop) or self._is_rung(self._deadline_ns, should_stop)
        if is_rung and came_near(self._clock, earliest_ns, should_stop):
            self._clock.sleep_until_ns(earliest_ns)
        return None if should_stop() else self._begin(is_rung)

    def farewell(self) -> Wakeup:
        """See `Pacer.farewell`."""
        return self._wake(self._clock.now_ns(), self._clock.now_ns(), 0)

    def now_ns(self) -> int:
        """See `Pacer.now_ns`."""
        return self._clock.now_ns()

    @property
    def _deadline_ns(self) -> int:
        """When the next tick begins without an input."""
        return self._nominal_ns + self._half_ns

    def _learn(self) -> None:
        """Learn from the input that began the last tick; only now, as that one had no time."""
        if self._occasions is not None and self._inbox.was_rung:
            self._expected.came(self._inbox.rung_ns)

    def _is_rung_early(self, should_stop: Callable[[], bool]) -> bool:
        """Wait until an input is expected, and rehearse; whether the bell rang before."""
        expected_ns = self._expected.next_ns()
        if self._occasions is None or expected_ns is None or expected_ns > self._deadline_ns:
            return False

        def is_rung(until_ns: int) -> bool:
            return self._is_rung(until_ns, should_stop)

        return self._occasions.before(expected_ns, is_rung)

    def _is_rung(self, end_ns: int, should_stop: Callable[[], bool]) -> bool:
        """Wait for the bell up to a time, or until asked to stop.

        A thread may be held up between its put and its ring: what it rings for was taken by a tick
        meanwhile, and the bell is armed anew.
        """
        clock = self._clock.before(self._deadline_ns)
        while not should_stop():
            until_ns = min(end_ns, clock.now_ns() + PATIENCE_NS)
            if clock.wait_until_ns(until_ns, self._bell):
                if self._inbox.was_rung:
                    return True
            elif until_ns == end_ns:
                break
        return False

    def _begin(self, is_rung: bool) -> Wakeup:
        """Begin a tick: move the nominal time on."""
        wake_ns = self._clock.now_ns()
        nominal_ns, deadline_ns = self._nominal_ns, self._deadline_ns
        missed = max(0, (wake_ns - deadline_ns) // self._period_ns)
        if is_rung:
            due_ns = max(self._inbox.rung_ns, nominal_ns - self._half_ns)
            nominal_ns = max(due_ns, nominal_ns)
            nominal_ns += max(0, (wake_ns - nominal_ns) // self._period_ns) * self._period_ns
        else:
            due_ns = deadline_ns
            nominal_ns += missed * self._period_ns
        self._slot = (nominal_ns - (self._start_ns or 0)) // self._period_ns
        self._nominal_ns = nominal_ns + self._period_ns
        return self._wake(due_ns, wake_ns, missed)

    def _wake(self, due_ns: int, wake_ns: int, missed: int) -> Wakeup:
        messages, now_ns = self._inbox.drain(self._clock.now_ns)
        return Wakeup(self._slot, due_ns, wake_ns, now_ns, messages, now_ns - wake_ns, missed)
