"""A walk through what a loop recorded, from its beginning to its end, over what is missing.

Where ticks or inputs are missing, the ticks behind them cannot be decided again: the walk leaves
them out, counts them, and goes on behind the next keyframe, or behind the next tick that tells what
the controller knew. So a tick is called different only if all that it rests on is there.
"""

from collections import deque
from collections.abc import Iterator

from reflexarc_logs.reading.reader import Log
from reflexarc_logs.replaying.beginning import (
    Beginning,
    keep,
    state_at,
    state_behind,
    tells_state,
)
from reflexarc_logs.replaying.comparison import EqualityRules, Tally
from reflexarc_logs.replaying.loop_events import LoopEvent
from reflexarc_logs.replaying.serving.served_policies import ServedPolicies
from reflexarc_logs.replaying.stepping import Stepping, TickComparison
from reflexarc_logs.replaying.tick_order import is_tick
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.controller_state import State
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages.wire import Message, UndecodableError, unpack_stamp
from reflexarc_runtime.policy.policy import LoadedPolicy


class Walk:
    """Takes what a loop recorded, event by event.

    Args:
        log: the log.
        policy: whom to ask.
        beginning: from where.
        rules: what counts as equal.
        tally: where ticks are counted.

    Raises:
        LogError: rules that this package does not know, or no description of ticks.
    """

    def __init__(
        self,
        log: Log,
        policy: LoadedPolicy,
        beginning: Beginning,
        rules: EqualityRules,
        tally: Tally,
    ) -> None:
        self.stepping = Stepping.at(beginning, policy, log, rules)
        self.is_lost = False
        """Whether what the controller knows is not known, since something is missing."""
        self._log, self._policy, self._tally = log, policy, tally
        self._served = beginning.served or ServedPolicies(log, policy)
        self._knows_more = beginning.knows_more
        self._left_out = 0
        self._first_left_out = 0
        self._unmet: tuple[pb.Keyframe, int] | None = None
        """A keyframe of another tick than the next one, and how many inputs stand before it."""

    @property
    def state(self) -> State:
        """What the controller knows."""
        return self.stepping.state

    def take(self, event: LoopEvent) -> None:
        """Take the next event.

        Raises:
            NoLoopError: more inputs without a tick than any inbox holds.
        """
        if isinstance(event, Message):
            keep(self.stepping.waiting, event, self._log)
        elif isinstance(event, pb.Keyframe):
            self._meet(event)
        else:
            self._come_to(event)

    def end(self) -> Iterator[str]:
        """Count what stands behind the last tick; what the reader should know."""
        stepping, tally = self.stepping, self._tally
        if stepping.surprises and tally.compared:  # of a keyframe behind the last tick
            tally.add(stepping.state.index, len(stepping.surprises), stepping.surprises)
        if self._left_out:
            yield (
                f"level node: {self._left_out} ticks were not compared, as ticks or inputs are "
                f"missing or stand twice; the first is tick {self._first_left_out}"
            )
        if stepping.waiting:
            yield f"{len(stepping.waiting)} inputs after the last tick"

    def _meet(self, keyframe: pb.Keyframe) -> None:
        stepping = self.stepping
        if self.is_lost or keyframe.index != self.state.index:
            self._unmet = keyframe, len(stepping.waiting)
        elif stepping.is_exact:
            stepping.meet(keyframe)
        elif (state := self._state_at(keyframe)) is not None:
            stepping.go_on(state, is_exact=True)

    def _come_to(self, tick: pb.Tick) -> None:
        decision = tick.decision
        self._resume(decision)
        expected = self.state.index
        if self.is_lost or not is_tick(decision, expected):
            self._leave_out(tick)
        elif len(self.stepping.waiting) < decision.inputs:
            self._decide_with_less(tick)
        else:
            self.stepping.compare(tick, self._tally)

    def _resume(self, decision: pb.Decision) -> None:
        """Go on from a keyframe, if it is this tick's and not the one that was to come."""
        unmet, self._unmet = self._unmet, None
        if unmet is None:
            return
        keyframe, before = unmet
        if not self.is_lost and is_tick(decision, self.state.index):
            self.stepping.meet(keyframe)  # nothing is missing: its number is wrong
        elif is_tick(decision, keyframe.index) and (state := self._state_at(keyframe)) is not None:
            for _ in range(before):
                self.stepping.waiting.popleft()  # they belong to ticks that are missing
            self.stepping.go_on(state, is_exact=True)
            self.is_lost = False

    def _state_at(self, keyframe: pb.Keyframe) -> State | None:
        try:
            return state_at(keyframe, self._policy, self._served)
        except LogError:
            return None

    def _leave_out(self, tick: pb.Tick) -> None:
        """Leave out a tick and its inputs; go on behind it, if it tells enough."""
        decision = tick.decision
        self._tally.ticks += 1
        self._first_left_out = self._first_left_out if self._left_out else decision.index
        self._left_out += 1
        self.stepping.waiting.clear()
        if not self.is_lost and decision.index < self.state.index:
            return  # it stands twice, or too late: nothing behind it is missing
        served = self._served
        policy = served.of(decision.policy_hash)
        self.is_lost = True
        if policy is None or self._knows_more or not tells_state(decision, policy.contract):
            return
        self.is_lost = False
        self.stepping.go_on(state_behind(decision, policy, served), is_exact=False)

    def _decide_with_less(self, tick: pb.Tick) -> None:
        """Decide a tick with fewer inputs than it says; a difference only if none is missing."""
        stepping = self.stepping
        before, taken = stepping.state, deque(stepping.waiting)
        found = stepping.decide(tick)
        if taken and not _lacks_one(before, taken) and self._only_counts_differ(found):
            stepping.count(tick, found, self._tally)
        else:
            stepping.state = before  # what was made of too little is not known
            self._leave_out(tick)

    def _only_counts_differ(self, found: TickComparison) -> bool:
        counting = self.stepping.rules.judge(*found)
        return [difference.path for difference in counting] == ["inputs"]


def _lacks_one(before: State, taken: deque[Message]) -> bool:
    """Whether a number is missing between the newest input that was used and these."""
    if before.newest is None:
        return False
    newest = before.newest.stamp
    for message in taken:
        try:
            stamp = unpack_stamp(message.attachment)
        except UndecodableError:
            continue
        if stamp.sender == newest.sender and stamp.sequence > newest.sequence:
            return stamp.sequence > newest.sequence + 1
    return False
