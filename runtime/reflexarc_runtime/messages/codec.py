"""Conversion between plain values and protobuf messages; bus and log carry the same bytes."""

import math
from dataclasses import dataclass

from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from google.protobuf.message import DecodeError
from google.protobuf.message import Message as ProtobufMessage
from google.protobuf.timestamp_pb2 import Timestamp

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.arrays import Retina
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.contract.eye_in_words import eye_in_words
from reflexarc_runtime.decision import Command, Decision, Input, Timing, Verdict
from reflexarc_runtime.messages.spread import Spread, spread_to_protobuf
from reflexarc_runtime.messages.topics import TOPICS

SCHEMAS: dict[str, type[ProtobufMessage]] = {topic.schema: topic.message for topic in TOPICS}
"""Every message of the topic table, by its full name."""

_NESTED = ("verdicts", "phases")
"""Fields of a status that are no plain values."""


@dataclass(frozen=True, slots=True)
class Status:
    """Counts and timing of a node over the last period."""

    node: str
    run_id: str = ""
    policy_hash: str = ""
    ticks: int = 0
    rate_hz: float = 0.0
    lateness_p50_ns: int = 0
    lateness_p99_ns: int = 0
    lateness_max_ns: int = 0
    skipped_slots: int = 0
    inbox_overflows: int = 0
    verdicts: tuple[tuple[str, int], ...] = ()
    recording: str = "off"
    guard: str = ""
    watchdog: str = ""
    sensor: str = ""
    phases: tuple[tuple[str, Spread], ...] = ()
    shadow: str = ""
    realtime: str = ""
    action: str = ""
    """Of the last tick, by name; empty: the safe command."""
    verdict: int = 0
    """Of the last tick; 0: of no tick."""
    policy: str = ""
    """The file of the policy that decides, shortened; empty: not known."""
    pace: str = ""
    contract_rate_hz: float = 0.0
    is_stand_in: bool = False
    """Said in the place of a late loop, whose rate and counts are not known."""


def timestamp(time_ns: int) -> Timestamp:
    """A protobuf time stamp."""
    return Timestamp(seconds=time_ns // 1_000_000_000, nanos=time_ns % 1_000_000_000)


def encode_retina(retina: Retina, spec: RetinaSpec, time_ns: int) -> bytes:
    """A retina as `foxglove.RawImage` that names its eye: width = rays, height = eyes."""
    image = RawImage(
        timestamp=timestamp(time_ns),
        frame_id=eye_in_words(spec),
        width=spec.rays,
        height=spec.eyes,
        encoding=spec.encoding,
        step=spec.rays * spec.channels,
        data=retina.tobytes(),
    )
    return image.SerializeToString()


def encode_tick(decision: Decision, timing: Timing) -> bytes:
    """A tick as `reflexarc.Tick`."""
    return pb.Tick(
        decision=decision_to_protobuf(decision), timing=_timing_to_protobuf(timing)
    ).SerializeToString()


def encode_command(command: Command) -> bytes:
    """A command as `reflexarc.Command`."""
    return _command_to_protobuf(command).SerializeToString()


def decode_command(payload: bytes) -> Command | None:
    """A command from the bus; None if it cannot be decoded or its speeds are not finite."""
    try:
        message = pb.Command.FromString(payload)
        speeds = (message.linear_mps, message.lateral_mps, message.angular_radps)
        if not all(map(math.isfinite, speeds)):
            return None
        return Command(
            sequence=message.sequence,
            action=message.action,
            verdict=Verdict(message.verdict),
            linear_mps=message.linear_mps,
            lateral_mps=message.lateral_mps,
            angular_radps=message.angular_radps,
            valid_for_ns=message.valid_for_ns,
            source_sequence=_optional(message, "source_sequence"),
            source_time_ns=_optional(message, "source_time_ns"),
            body=message.body,
        )
    except (DecodeError, ValueError):
        return None


def encode_status(status: Status) -> bytes:
    """A status as `reflexarc.Status`."""
    fields = {name: getattr(status, name) for name in Status.__slots__ if name not in _NESTED}
    phases = [spread_to_protobuf(name, spread) for name, spread in status.phases]
    message = pb.Status(**fields, verdicts=dict(status.verdicts), phases=phases)
    return message.SerializeToString()


def encode_warning(words: str, node: str, time_ns: int) -> bytes:
    """A warning of a node as `foxglove.Log`."""
    log = Log(timestamp=timestamp(time_ns), level=Log.WARNING, message=words, name=node)
    return log.SerializeToString()


def encode_contact(count: int, x_m: float, y_m: float, time_ns: int) -> bytes:
    """The beginning of a collision as `reflexarc.Contact`."""
    return pb.Contact(count=count, x_m=x_m, y_m=y_m, time_ns=time_ns).SerializeToString()


def decision_to_protobuf(decision: Decision) -> pb.Decision:
    """A decision as `reflexarc.Decision`, the form in which replays are compared."""
    return pb.Decision(
        index=decision.index,
        slot=decision.slot,
        now_ns=decision.now_ns,
        inputs=decision.inputs,
        input=_input_to_protobuf(decision.input),
        retina=decision.retina,
        q_values=decision.q_values,
        action=decision.action,
        verdict=int(decision.verdict),  # type: ignore[arg-type]  # the stub knows only its own enum
        reason=decision.reason,
        command=_command_to_protobuf(decision.command),
        policy_hash=decision.policy_hash,
        winner=decision.winner,
        state=decision.state,
    )


def _input_to_protobuf(used: Input | None) -> pb.Input | None:
    if used is None:
        return None
    return pb.Input(
        sequence=used.sequence,
        source_time_ns=used.source_time_ns,
        received_ns=used.received_ns,
        age_ns=used.age_ns,
    )


def _command_to_protobuf(command: Command) -> pb.Command:
    return pb.Command(
        sequence=command.sequence,
        action=command.action,
        verdict=int(command.verdict),  # type: ignore[arg-type]  # the stub knows only its own enum
        linear_mps=command.linear_mps,
        lateral_mps=command.lateral_mps,
        angular_radps=command.angular_radps,
        valid_for_ns=command.valid_for_ns,
        source_sequence=command.source_sequence,
        source_time_ns=command.source_time_ns,
        body=command.body,
    )


def _timing_to_protobuf(timing: Timing) -> pb.Timing:
    """Without what the others tell: it woke `receive_ns` before the tick's `now_ns`."""
    return pb.Timing(
        lateness_ns=timing.lateness_ns,
        receive_ns=timing.receive_ns,
        decide_ns=to_us(timing.decide_ns),
        publish_ns=to_us(timing.publish_ns),
        record_ns=to_us(timing.record_ns),
    )


def to_us(time_ns: int) -> int:
    """A time that a phase took, to the microsecond: below it are digits that no one can use."""
    return (time_ns + 500) // 1000 * 1000


def _optional(message: pb.Command, name: str) -> int | None:
    return getattr(message, name) if message.HasField(name) else None
