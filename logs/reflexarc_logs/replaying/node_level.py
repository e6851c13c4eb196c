"""Replay at level `node`: the inputs of each tick through the controller, every field compared.

Each tick takes its `inputs` next messages in file order; no time stamp decides what belongs to
which tick. Where the log has a keyframe, what the controller knows is compared with it. Timing is
never compared.
"""

from reflexarc_logs.container.run_info import LOOPS
from reflexarc_logs.reading.reader import Log
from reflexarc_logs.replaying.beginning import begin, keep
from reflexarc_logs.replaying.comparison import EqualityRules, LevelResult, Tally
from reflexarc_logs.replaying.loop_events import beside_the_sensor, loop_events
from reflexarc_logs.replaying.stepping import Stepping
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.messages.topics import REJECTED, SENSORS
from reflexarc_runtime.messages.wire import Message
from reflexarc_runtime.policy.policy import LoadedPolicy


def replay_node(
    log: Log, policy: LoadedPolicy, rules: EqualityRules
) -> tuple[LevelResult, list[str]]:
    """Step a controller through the log.

    Returns:
        The result, and what its reader should know.

    Raises:
        LogError: the log cannot be read, or was not recorded by a loop.
    """
    beginning, events = begin(log, loop_events(log), policy)
    stepping = Stepping.at(beginning, policy, log, rules)
    tally = Tally("node", rules, ticks=beginning.skipped_ticks)
    for event in events:
        if isinstance(event, Message):
            keep(stepping.waiting, event, log)
        elif isinstance(event, pb.Keyframe):
            stepping.meet(event)
        else:
            stepping.compare(event, tally)
    if stepping.surprises and tally.compared:  # of a keyframe behind the last tick
        tally.add(stepping.state.index, len(stepping.surprises), stepping.surprises)
    left_over = len(stepping.waiting)
    notes = [f"{left_over} inputs after the last tick"] * bool(left_over)
    return tally.result(stepping.fields.not_compared), [*filter(None, [beginning.note]), *notes]


def why_not(log: Log) -> str:
    """What keeps a log from being replayed at level `node`; empty if nothing does."""
    if log.run.recorded_by == "import":
        return "it was imported from another system; no loop of ours decided on it"
    if log.run.recorded_by not in LOOPS:
        return "it was recorded by a listener, whose order is not the loop's"
    if log.dropped:
        return f"{log.dropped} records or chunks are missing in its middle"
    sensor = log.topic(SENSORS[log.run.input].name)
    stream = next(log.records(sensor, log.topic(REJECTED.name)), None)
    if stream is None and _inputs_taken(log) > _others(log):
        return f"it has no sensor stream ({sensor})"
    return ""


def _inputs_taken(log: Log) -> int:
    return sum(tick.decision.inputs for tick in log.ticks())


def _others(log: Log) -> int:
    """Stops, resets, a guard's own ranges: inputs that are not what it decided on."""
    topics = (log.topic(topic.name) for topic in beside_the_sensor(log))
    return sum(1 for _ in log.records(*topics))
