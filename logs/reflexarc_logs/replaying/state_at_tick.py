"""What a controller knew in front of a tick: found by replaying all ticks before it."""

from dataclasses import dataclass

from reflexarc_logs.reading.reader import Log
from reflexarc_logs.replaying.beginning import begin
from reflexarc_logs.replaying.comparison import EqualityRules, Tally
from reflexarc_logs.replaying.loop_events import loop_events
from reflexarc_logs.replaying.walk import Walk
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.controller_state import State
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages.topics import TICK
from reflexarc_runtime.policy.policy import Backend, LoadedPolicy


@dataclass(frozen=True)
class KnownState:
    """What a controller knew, and when."""

    state: State
    at_ns: int
    """Behind the tick before, and in front of every message that came after it; monotonic."""
    notes: list[str]


def state_at_tick(log: Log, policy: LoadedPolicy, index: int) -> KnownState:
    """Replay a log up to a tick.

    Args:
        log: what a loop recorded.
        policy: the policy that it ran.
        index: the tick in front of which to stop. Of a slice's first tick the next one that is
            known takes the place.

    Raises:
        LogError: the log cannot be read, or it does not tell enough before this tick.
    """
    beginning, events = begin(log, loop_events(log), policy)
    is_first = index <= next(log.ticks()).decision.index
    if is_first and beginning.state is not None:
        index = max(index, beginning.state.index)
    if beginning.state is None or beginning.state.index > index:
        first = "nowhere" if beginning.state is None else f"from tick {beginning.state.index} on"
        raise LogError(
            f"{log.path}: what the controller knew in front of tick {index} is not known: the log "
            f"is a slice that tells it {first}; cut there"
        )
    exact = Backend.NUMPY == policy.backend == log.run.backend
    rules = EqualityRules(exact, True, policy.contract.q_tolerance)
    tally = Tally("node", rules)
    walk, at_ns = Walk(log, policy, beginning, rules, tally), _earliest_ns(log)
    while walk.state.index < index and (event := next(events, None)) is not None:
        walk.take(event)
        if isinstance(event, pb.Tick):
            at_ns = event.decision.now_ns
    if walk.is_lost or walk.state.index > index:
        raise LogError(
            f"{log.path}: what the controller knew in front of tick {index} is not known: ticks or "
            "inputs are missing before it; cut elsewhere"
        )
    return KnownState(walk.state, at_ns, _notes(tally, index))


def _notes(tally: Tally, index: int) -> list[str]:
    different = tally.compared - tally.identical
    if not different:
        return []
    return [
        f"before tick {index}, {different} ticks replay differently from the log; the keyframe is "
        "what the replay knew"
    ]


def _earliest_ns(log: Log) -> int:
    """Arrival of the earliest message in front of the first tick, monotonic."""
    earliest_ns = None
    for record in log.records():
        earliest_ns = record.log_ns if earliest_ns is None else min(earliest_ns, record.log_ns)
        if record.topic == log.topic(TICK.name):
            break
    return (earliest_ns or 0) - log.run.wall_offset_ns
