"""Decides on a log of sensors alone, as `run --record` would have on the robot that recorded it.

The real loop runs on the log's own time: a tick at each deadline of the contract's rate, with the
messages that had arrived by then. What comes out is a log of a loop, which replays at both levels.
Open loop: what the sensors saw was not moved by what is decided now.
"""

import hashlib
import json
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from reflexarc_logs.container.rejected import Intake
from reflexarc_logs.container.run_info import WALL_CLOCK, RunInfo, installed_versions
from reflexarc_logs.deciding.log_clock import LogClock
from reflexarc_logs.deciding.sensor_messages import SensorMessages, sensors_of
from reflexarc_logs.reading.reader import Log, read_log
from reflexarc_logs.recording.part import Head, Part
from reflexarc_logs.recording.place import Place
from reflexarc_runtime.controller import Controller
from reflexarc_runtime.decision import Verdict
from reflexarc_runtime.errors import LogError, UsageError
from reflexarc_runtime.guard import Guard, asks_the_input
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.keyframe import Keyframe
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.node import Node
from reflexarc_runtime.loop.outlets import NoOutlet, Outlets
from reflexarc_runtime.loop.pacing.rate_pacer import RatePacer
from reflexarc_runtime.loop.tick_record import TickRecord
from reflexarc_runtime.messages.topics import SENSORS
from reflexarc_runtime.messages.wire import Message
from reflexarc_runtime.policy.policy import LoadedPolicy
from reflexarc_runtime.rules import CURRENT_RULES
from reflexarc_runtime.sensing.sense_settings import SenseSettings
from reflexarc_runtime.sensing.senses import sense_for

MAX_TICKS = 20_000_000
"""Eleven hours at 500 Hz; a log that lasts longer has a clock that jumped."""


@dataclass(frozen=True)
class Decided:
    """What came of deciding on a log."""

    path: Path
    sensor: str
    ticks: int
    verdicts: Mapping[str, int]
    left_out: Mapping[str, int]
    """Messages of the log that no loop takes in or records, by topic."""
    why_nothing: str = ""
    """Why the policy was asked at no tick at all; empty: it was."""


def decide(
    log: Log,
    policy: LoadedPolicy,
    out: Path | str,
    *,
    sensor: str = "",
    senses: SenseSettings | None = None,
    guard: GuardSettings | None = None,
) -> Decided:
    """Run a policy's loop on the sensors of a log, and record it.

    Args:
        log: ours, or imported; what it decided itself is left out.
        policy: what decides.
        out: the log to be; it must not exist.
        sensor: retina or scan; the only one of the log if empty.
        senses: how to read what came.
        guard: the settings of a guard.

    Raises:
        LogError: the log has no such stream, or `out` cannot be written.
        ContractError: the policy cannot see what the sensor sent.
        UsageError: no such sensor, or the log has several and none is named.
    """
    sensor = _sensor(log, sensor)
    senses = senses or SenseSettings()
    rules = Guard.for_contract(guard, policy.contract) if guard else None
    sense = sense_for(sensor, policy.contract.retina, senses, guarded=asks_the_input(rules))
    controller = Controller(policy, policy.contract, sense, policy.policy_hash, guard=rules)
    head = _head(log, policy, sensor, senses, guard)
    beside = [controller.ranges_topic] if controller.ranges_topic is not None else []
    messages = SensorMessages(log, (SENSORS[sensor], *beside))
    try:
        with LogSink(Path(out), head) as sink:
            verdicts = _run(controller, messages, sink, head.run)
    except OSError as error:
        raise LogError(f"{out}: cannot be written: {error.strerror}; nothing is kept") from None
    counts, why_nothing = dict(verdicts), _why_nothing(Path(out))
    left_out = dict(messages.left_out)
    return Decided(Path(out), sensor, verdicts.total(), counts, left_out, why_nothing)


class LogSink:
    """A `Sink` that writes at once: here nobody waits for it."""

    state = "on"

    def __init__(self, path: Path, head: Head) -> None:
        self._intake = Intake(head.run.robot)
        self._part = Part(path, head, Place(path))

    def __enter__(self) -> "LogSink":
        return self

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        if kind is None:
            self._part.finish({})
        else:
            self._part.discard()

    def put(self, message: Message) -> None:
        """See `Sink.put`."""
        self._part.write(self._intake.sort(message))

    def put_tick(self, record: TickRecord) -> None:
        """See `Sink.put_tick`."""
        for message in record.messages():
            self.put(message)

    def put_keyframe(self, keyframe: Keyframe) -> None:
        """See `Sink.put_keyframe`."""
        self._part.write(self._intake.sort(keyframe))


def _run(
    controller: Controller, messages: SensorMessages, sink: LogSink, run: RunInfo
) -> Counter[str]:
    inbox = Inbox()

    def deliver(message: Message) -> None:
        (inbox if messages.reaches_the_loop(message) else sink).put(message)

    clock = LogClock(iter(messages), deliver, round(1e9 / run.rate_hz))
    pacer = RatePacer(run.rate_hz, clock, inbox)
    nowhere = NoOutlet()
    node = Node(
        controller,
        pacer,
        Outlets(nowhere, nowhere, nowhere),
        sink=sink,
        robot=run.robot,
        run_id=run.run_id,
        overflows=lambda: inbox.overflows,
    )
    summary = node.run(lambda: clock.is_over, MAX_TICKS)
    if not clock.is_over:
        raise LogError(f"expected at most {MAX_TICKS} ticks; the log's clock jumps")
    return Counter(summary.verdicts)


def _why_nothing(path: Path) -> str:
    """What the first refusal says, if no tick got as far as to the policy."""
    first = ""
    for tick in read_log(path).ticks():
        if tick.decision.q_values:
            return ""
        if not first and int(tick.decision.verdict) == Verdict.INVALID_INPUT:
            first = tick.decision.reason
    return first or "no input came that the loop could use"


def _sensor(log: Log, asked: str) -> str:
    found = sensors_of(log)
    if not found:
        raise LogError(f"{log.path}: expected retinas or scans of {log.run.robot}, found none")
    if asked and asked not in SENSORS:
        raise UsageError(f"--input: expected {' or '.join(SENSORS)}, got {asked!r}")
    if not asked and len(found) > 1:
        raise UsageError(f"{log.path}: it has {' and '.join(found)}; choose one with --input")
    if asked and asked not in found:
        raise LogError(f"{log.path}: expected {asked}s, found {' and '.join(found)}s only")
    return asked or found[0]


def _head(
    log: Log,
    policy: LoadedPolicy,
    sensor: str,
    senses: SenseSettings,
    guard: GuardSettings | None,
) -> Head:
    contract = policy.contract
    run = RunInfo(
        run_id=_run_id(log, policy),
        robot=log.run.robot,
        input=sensor,
        backend=policy.backend.value,
        rate_hz=contract.rate_hz,
        recorded_by="decide",
        rules=CURRENT_RULES.version,
        guard="" if guard is None else guard.to_json(),
        senses=senses.to_json(),
        policy_seed=contract.provenance.seed,
        commit=contract.provenance.commit,
        host=log.run.host,
        versions=installed_versions(),
        policy_hash=policy.policy_hash,
        wall_offset_ns=log.run.wall_offset_ns,
        publish_clock=WALL_CLOCK,
    )
    config = {"contract": json.loads(contract.to_json()), "decided_on": log.path.name}
    return Head(run, policy.data, config)


def _run_id(log: Log, policy: LoadedPolicy) -> str:
    """Of the same decisions the same one: deciding again gives the same log."""
    whole = f"{log.run.run_id} {log.path.name} {policy.policy_hash} {policy.backend.value}"
    return hashlib.sha256(whole.encode()).hexdigest()[:32]
