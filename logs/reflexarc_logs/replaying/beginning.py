"""Where a replay of a loop begins: at its first tick, or where a slice of a log tells enough.

A slice holds neither all messages nor what the controller knew when it begins. Behind a keyframe
all is known; without one, a policy that neither remembers nor holds is known behind its first tick
with verdict OK, because a tick holds what the policy was given.
"""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import chain

import numpy as np

from reflexarc_logs.reading.reader import Log
from reflexarc_logs.replaying.loop_events import LoopEvent, NoLoopError
from reflexarc_logs.replaying.serving.served_policies import ServedPolicies
from reflexarc_runtime.backlog import begun
from reflexarc_runtime.choice import Hold
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.controller_state import SINCE_THE_START, BoundBody, Serving, State
from reflexarc_runtime.decision import Verdict
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.keyframe import decode_state
from reflexarc_runtime.loop.inbox import DEFAULT_CAPACITY
from reflexarc_runtime.messages.topics import SCAN
from reflexarc_runtime.messages.wire import NO_SENDER, Message, Stamp
from reflexarc_runtime.messages_pb2 import Decision, Keyframe, Tick
from reflexarc_runtime.policy.policy import LoadedPolicy
from reflexarc_runtime.sensing.sense_settings import SenseSettings
from reflexarc_runtime.sensing.senses import Sensed

MAX_WAITING = 16 * DEFAULT_CAPACITY
"""So many inputs without a tick are no log of a loop: an inbox holds far fewer."""


@dataclass
class Beginning:
    """The state from which a replay steps on, and the messages that its first tick takes."""

    state: State | None = None
    """None: the log nowhere tells enough."""
    waiting: deque[Message] = field(default_factory=deque)
    skipped_ticks: int = 0
    """Ticks before it, which are not replayed."""
    is_exact: bool = True
    """Whether the state is the whole one, so that later keyframes can be compared with it."""

    knows_more: bool = False
    """Whether the loop knows what no tick holds: whole scans, how the body moves, or for how long
    its picture has not changed."""
    served: ServedPolicies | None = None
    """Who decided on the log."""

    @property
    def note(self) -> str:
        """What was left out; empty if nothing was."""
        if self.state is None:
            return (
                "level node was left out: it is a slice without a keyframe, and nothing in it "
                "tells what the controller knew"
            )
        if not self.state.index:
            return ""
        left_out = f"; {self.skipped_ticks} ticks before were left out" * bool(self.skipped_ticks)
        return f"level node begins behind tick {self.state.index - 1}: a slice{left_out}"


def begin(
    log: Log,
    events: Iterator[LoopEvent],
    policy: LoadedPolicy,
    served: ServedPolicies | None = None,
) -> tuple[Beginning, Iterator[LoopEvent]]:
    """Find where a replay may begin; returns it with the events that follow.

    Raises:
        LogError: a keyframe is not of this policy's contract, or no loop recorded the log.
    """
    served = served or ServedPolicies(log, policy)
    start = Beginning(knows_more=_knows_more(log), served=served)
    for event in events:
        if isinstance(event, Message):
            keep(start.waiting, event, log)
        elif isinstance(event, Keyframe):
            if not start.skipped_ticks:
                start.waiting.clear()  # they belong to a tick before the slice
            start.state = state_at(event, policy, served)
            if start.state is not None:
                return start, events
        elif event.decision.index == 0 and event.decision.inputs <= len(start.waiting):
            start.state = State()
            return start, chain([event], events)
        elif _skip(start, event, served):
            return start, events
    return start, events


def _knows_more(log: Log) -> bool:
    if log.run.senses and SenseSettings.from_json(log.run.senses).frozen_after_s is not None:
        return True
    if not log.run.guard:
        return False
    settings = GuardSettings.from_json(log.run.guard)
    return SCAN.name in (log.run.input, settings.ranges) or settings.follows_mps2 is not None


def keep(waiting: deque[Message], message: Message, log: Log) -> None:
    """Keep a message for the tick that takes it.

    Raises:
        NoLoopError: more than any inbox holds.
    """
    if len(waiting) >= MAX_WAITING:
        raise NoLoopError(log, f"{MAX_WAITING} inputs and no tick that took them")
    waiting.append(message)


def state_at(
    keyframe: Keyframe, policy: LoadedPolicy, served: ServedPolicies | None = None
) -> State | None:
    """What a policy's controller would know at a keyframe.

    Another policy than the recorded one has neither its memory nor its held action, and nobody
    took over from it; None if it sees something else, or if who served is not known.

    Raises:
        LogError: the keyframe is not of this policy's contract.
    """
    if not keyframe.policy_hash or keyframe.policy_hash == policy.policy_hash:
        return decode_state(keyframe, policy.contract)
    if served is not None and served.are_followed:
        serving = served.named(keyframe.policy_hash)
        return None if serving is None else decode_state(keyframe, serving.contract)
    keyframe.ClearField("serving")
    keyframe.ClearField("memory")
    keyframe.ClearField("hold")
    try:
        return decode_state(keyframe, policy.contract)
    except LogError:
        return None


def _skip(start: Beginning, tick: Tick, served: ServedPolicies) -> bool:
    """Leave a tick out; True if the replay may begin behind it."""
    start.skipped_ticks += 1
    for _ in range(min(tick.decision.inputs, len(start.waiting))):
        start.waiting.popleft()
    policy = served.of(tick.decision.policy_hash)
    if policy is None or start.knows_more or not tells_state(tick.decision, policy.contract):
        return False
    start.state, start.is_exact = state_behind(tick.decision, policy, served), False
    return True


def tells_state(decision: Decision, contract: PolicyContract) -> bool:
    """Whether a tick tells what a controller knew behind it, where no guard or sense knows more."""
    return not contract.state.size and not contract.hold_s and _tells_all(decision, contract)


def _tells_all(decision: Decision, contract: PolicyContract) -> bool:
    size = contract.retina.frames * contract.retina.size
    is_known = 0 <= decision.action < len(contract.actions)
    return decision.verdict == Verdict.OK.value and len(decision.retina) == size and is_known


def state_behind(decision: Decision, policy: LoadedPolicy, served: ServedPolicies) -> State:
    """The state behind a tick with verdict OK, as far as it decides anything.

    Args:
        decision: of the tick.
        policy: who decided it, or the candidate.
        served: who decided on the log.
    """
    contract = policy.contract
    is_first = policy.policy_hash == served.first.policy_hash
    stack = np.frombuffer(decision.retina, np.uint8).reshape(contract.retina.stack_shape)
    used, frames = decision.input, tuple(stack)
    sender = decision.command.body or NO_SENDER
    stamp = Stamp(used.sequence, used.source_time_ns, sender)
    behind_ns = used.age_ns - (decision.now_ns - used.received_ns)  # 0 before rules 4
    return State(
        index=decision.index + 1,
        streak=contract.recovery_inputs,
        newest=Sensed(stamp, used.received_ns, frames[-1]),
        frames=frames,
        hold=Hold(decision.action, decision.slot),
        source=BoundBody(sender, used.received_ns) if decision.command.body else None,
        backlog=begun(behind_ns, used.source_time_ns, used.received_ns),
        serving=SINCE_THE_START if is_first else Serving(policy.policy_hash),
        drove=_moves(decision),
    )


def _moves(decision: Decision) -> bool:
    told = decision.command
    return (told.linear_mps, told.lateral_mps, told.angular_radps) != (0.0, 0.0, 0.0)
