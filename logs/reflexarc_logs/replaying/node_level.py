"""Replay at level `node`: the inputs of each tick through the controller, every field compared.

Each tick takes its `inputs` next messages in file order; no time stamp decides what belongs to
which tick. What reached the loop and could not be decoded comes from the channel of rejected
messages, in its place. Timing is never compared.
"""

from collections import deque
from collections.abc import Iterator

from reflexarc_logs.container.rejected import accepted_message, rejected_message
from reflexarc_logs.reading.reader import Log, Record, decode
from reflexarc_logs.replaying.comparison import EqualityRules, Flip, LevelResult, Tally, find_flip
from reflexarc_logs.replaying.message_fields import Fields, message_type
from reflexarc_runtime.controller import Controller, Inputs, State
from reflexarc_runtime.decision import Verdict
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.loop.inbox import DEFAULT_CAPACITY
from reflexarc_runtime.messages.codec import decision_to_protobuf
from reflexarc_runtime.messages.topics import REJECTED, SENSORS, TICK
from reflexarc_runtime.messages.wire import Message, Stamp
from reflexarc_runtime.messages_pb2 import Decision, Rejected, Tick
from reflexarc_runtime.policy.policy import LoadedPolicy
from reflexarc_runtime.sensing.senses import sense_for

MAX_WAITING = 16 * DEFAULT_CAPACITY
"""So many inputs without a tick are no log of a loop: an inbox holds far fewer."""


def replay_node(log: Log, policy: LoadedPolicy, rules: EqualityRules) -> tuple[LevelResult, int]:
    """Step a controller through the log.

    Returns:
        The result, and how many inputs came after the last tick.

    Raises:
        LogError: the log cannot be read, or was not recorded by a loop.
    """
    sense = sense_for(log.run.input, policy.contract.retina)
    controller = Controller(policy, policy.contract, sense, policy.policy_hash)
    theirs = message_type(log.tick_descriptor(), "decision")
    fields = Fields(Decision.DESCRIPTOR, theirs)  # type: ignore[arg-type]  # one of two stubs
    tally = Tally("node", rules)
    waiting: deque[Message] = deque()
    state = State()
    for event in events(log):
        if isinstance(event, Message):
            _keep(waiting, event, log)
            continue
        recorded = event.decision
        inputs = _inputs(waiting, recorded)
        state, decision = controller.step(state, inputs, recorded.now_ns)
        replayed = decision_to_protobuf(decision)
        tally.ticks += 1
        differences = fields.differences(recorded, replayed)
        tally.add(recorded.index, fields.count, differences, _flip(recorded, replayed))
    return tally.result(fields.not_compared), len(waiting)


def events(log: Log) -> Iterator[Message | Tick]:
    """The sensor messages as the loop got them, and the ticks, in file order.

    Raises:
        LogError: the log cannot be read.
    """
    key = SENSORS[log.run.input].key(log.run.robot)
    tick, rejected = log.topic(TICK.name), log.topic(REJECTED.name)
    for record in log.records(f"/{key}", tick, rejected):
        received_ns = record.log_ns - log.run.wall_offset_ns
        if record.topic == tick:
            yield decode(log, record, Tick)
        elif record.topic == rejected:
            message = rejected_message(decode(log, record, Rejected), received_ns)
            if message.key == key:
                yield message
        else:
            yield _accepted(key, record, received_ns)


def why_not(log: Log) -> str:
    """What keeps a log from being replayed at level `node`; empty if nothing does."""
    if log.run.recorded_by == "import":
        return "it was imported from another system; no loop of ours decided on it"
    if log.run.recorded_by != "run":
        return "it was recorded by a listener, whose order is not the loop's"
    if log.dropped:
        return f"{log.dropped} records or chunks are missing in its middle"
    sensor = log.topic(SENSORS[log.run.input].name)
    stream = next(log.records(sensor, log.topic(REJECTED.name)), None)
    if stream is None and any(tick.decision.inputs for tick in log.ticks()):
        return f"it has no sensor stream ({sensor})"
    return ""


def _accepted(key: str, record: Record, received_ns: int) -> Message:
    stamp = Stamp(record.sequence, record.publish_ns)
    return accepted_message(key, record.schema, record.payload, stamp, received_ns)


def _keep(waiting: deque[Message], message: Message, log: Log) -> None:
    if len(waiting) >= MAX_WAITING:
        raise LogError(
            f"{log.path}: {MAX_WAITING} inputs and no tick that took them: not a log of "
            "`run --record`; use --level policy"
        )
    waiting.append(message)


def _inputs(waiting: deque[Message], recorded: Decision) -> Inputs:
    """What the loop had drained; where the log holds less, the count itself will differ."""
    count = min(recorded.inputs, len(waiting))
    messages = tuple(waiting.popleft() for _ in range(count))
    return Inputs(messages, recorded.slot, stop=recorded.verdict == Verdict.STOPPED.value)


def _flip(recorded: Decision, replayed: Decision) -> Flip | None:
    if {recorded.verdict, replayed.verdict} != {Verdict.OK.value}:
        return None
    return find_flip(recorded.index, recorded.q_values, recorded.action, replayed.action)
