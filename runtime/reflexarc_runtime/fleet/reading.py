"""From a message on `<robot>/status` or `<robot>/lease` to what was said.

Fields that a younger version has added are passed over. What no node of ours sends is refused:
another encoding, no stamp, a node of no known kind.
"""

from collections.abc import Mapping
from itertools import islice
from math import isfinite

from google.protobuf.message import DecodeError

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.decision import Verdict
from reflexarc_runtime.fleet.said import OTHER, BodySaid, LeaseSaid, RuntimeSaid, Word
from reflexarc_runtime.messages.spread import Spread
from reflexarc_runtime.messages.topics import BODY_NODE, LEASE, RUNTIME_NODE, STATUS
from reflexarc_runtime.messages.wire import Message, UndecodableError, check_encoding, unpack_stamp
from reflexarc_runtime.words.shown import plain

MOST_NAME = 64
"""Characters of a robot's name that are told apart, as long as a name may be."""
_MOST_TEXT = 120
_MOST_REASONS = 16
_MOST_PHASES = 16
_MOST_BITS = 64


def read_word(message: Message) -> Word:
    """What a message says.

    Raises:
        UndecodableError: it is no status and no lease of a node of ours.
    """
    robot, _, name = message.key.partition("/")
    sender = unpack_stamp(message.attachment).sender
    if name == STATUS.name:
        said = _status(message)
    elif name == LEASE.name:
        said = _lease(message)
    else:
        raise UndecodableError(f"key: expected a status or a lease, got {message.key[:80]!r}")
    return Word(shown_name(robot), sender, message.received_ns, said)


def shown_name(robot: str) -> str:
    """A robot's name as it is told apart and shown, whatever characters a key holds."""
    return plain(robot)[:MOST_NAME]


def _status(message: Message) -> RuntimeSaid | BodySaid | LeaseSaid:
    check_encoding(message, STATUS.schema)
    try:
        status = pb.Status.FromString(message.payload)
    except DecodeError as error:
        raise UndecodableError(f"status: {error}") from None
    if status.node == BODY_NODE:
        return BodySaid(_cut(status.guard), status.inbox_overflows)
    if status.node == RUNTIME_NODE:
        return _runtime(status)
    raise UndecodableError(f"node: expected runtime or body, got {status.node[:80]!r}")


def _runtime(status: pb.Status) -> RuntimeSaid:
    return RuntimeSaid(
        run_id=_cut(status.run_id),
        rate_hz=_rate(status.rate_hz),
        contract_rate_hz=_rate(status.contract_rate_hz) or None,
        pace=_cut(status.pace),
        ticks=status.ticks,
        skipped_slots=status.skipped_slots,
        inbox_overflows=status.inbox_overflows,
        verdict=_verdict(status.verdict),
        verdicts=_known_verdicts(status.verdicts),
        action=_cut(status.action),
        policy=_cut(status.policy),
        policy_hash=_cut(status.policy_hash),
        guard=_cut(status.guard),
        recording=_cut(status.recording),
        watchdog=_cut(status.watchdog),
        sensor=_cut(status.sensor),
        shadow=_cut(status.shadow),
        phases={_cut(each.phase): _spread(each) for each in status.phases[:_MOST_PHASES]},
        is_stand_in=status.is_stand_in,
    )


def _lease(message: Message) -> LeaseSaid:
    check_encoding(message, LEASE.schema)
    try:
        lease = pb.Lease.FromString(message.payload)
    except DecodeError as error:
        raise UndecodableError(f"lease: {error}") from None
    return LeaseSaid(
        holder=lease.holder[:16],
        epoch=lease.epoch,
        armed=lease.armed,
        stopped=_cut(lease.stopped),
        words=_cut(lease.state),
        refused=_few_reasons(lease.refused),
    )


def _cut(text: str) -> str:
    return plain(text[:_MOST_TEXT])[:_MOST_TEXT]


def _rate(rate_hz: float) -> float | None:
    return rate_hz if isfinite(rate_hz) and rate_hz >= 0.0 else None


def _verdict(number: int) -> str:
    if number == 0:
        return ""
    return Verdict(number).name if number in Verdict.__members__.values() else OTHER


def _known_verdicts(counts: Mapping[str, int]) -> dict[str, int]:
    """By name, in the order of the verdicts; what a younger version has added, together."""
    known = {name: counts[name] for name in Verdict.__members__ if name in counts}
    other = sum(counts.values()) - sum(known.values())
    return {**known, OTHER: other} if other else known


def _few_reasons(counts: Mapping[str, int]) -> dict[str, int]:
    few: dict[str, int] = {}
    for reason, count in islice(sorted(counts.items()), _MOST_REASONS):
        few[_cut(reason)] = few.get(_cut(reason), 0) + count
    other = sum(counts.values()) - sum(few.values())
    return {**few, OTHER: other} if other else few


def _spread(times: pb.PhaseTimes) -> Spread:
    return Spread(
        times.count,
        times.p50_ns,
        times.p99_ns,
        times.p999_ns,
        times.max_ns,
        min(times.least_bits, _MOST_BITS),
        tuple(times.octaves[:_MOST_BITS]),
        times.sum_ns,
    )
