"""A controller's state as a message: replay may begin behind one.

`reflexarc.Keyframe` holds all that the controller remembers between two ticks, so that what comes
behind it in a log replays without what came before it.
"""

from dataclasses import dataclass

import numpy as np

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.arrays import Memories, Retina
from reflexarc_runtime.backlog import NO_LAG, Lag, LeastDelay
from reflexarc_runtime.choice import Hold
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.controller_state import (
    SINCE_THE_START,
    BoundBody,
    RangeState,
    Serving,
    State,
)
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.inertia import STILL, Moving
from reflexarc_runtime.messages.wire import Stamp
from reflexarc_runtime.sensing.ranges import Ranged
from reflexarc_runtime.sensing.scan import Scan, UnusableScanError, check_sweep
from reflexarc_runtime.sensing.senses import Sensed
from reflexarc_runtime.sensing.stillness import MOVING, Still

MAX_COUNT = 1 << 62
"""More ticks or inputs than any loop counts."""


@dataclass(frozen=True, slots=True)
class Keyframe:
    """What the controller remembered, and when."""

    state: State
    received_ns: int
    """The time of the tick before, on the runtime's monotonic clock."""
    policy_hash: str = ""
    sender: bytes = b""


def encode_state(state: State, policy_hash: str) -> bytes:
    """A controller's state as `reflexarc.Keyframe`.

    Args:
        state: what it remembers.
        policy_hash: of the policy of the start; where another one serves, the state says so.
    """
    ranges = state.ranges
    return pb.Keyframe(
        index=state.index,
        policy_hash=state.serving.policy_hash or policy_hash,
        streak=state.streak,
        newest=_accepted(state.newest),
        frames=[frame.tobytes() for frame in state.frames],
        fault=state.fault,
        memory=_memory(state),
        hold=None if state.hold is None else _hold(state.hold),
        stopped=state.stopped or None,
        source=None if state.source is None else _source(state.source),
        ranges=None if ranges.newest is None else _ranged(ranges.newest),
        ranges_source=None if ranges.source is None else _source(ranges.source),
        ranges_fault=ranges.fault,
        moving=None if state.moving is None else _told(state.moving),
        backlog=_backlog(state.backlog),
        ranges_backlog=_backlog(ranges.backlog),
        still=_still(state.still),
        serving=_serving(state.serving),
        drove=state.drove,
    ).SerializeToString()


def decode_state(message: pb.Keyframe, contract: PolicyContract) -> State:
    """The state that a keyframe holds.

    Raises:
        LogError: it is not of this contract's eye, memory or actions.
    """
    if max(message.index, message.streak) > MAX_COUNT:
        raise LogError(_unfit("counts", f"at most {MAX_COUNT}", "more"))
    frames = tuple(_retina(frame, contract) for frame in message.frames)
    if len(frames) not in (0, contract.retina.frames):
        raise LogError(_unfit("frames", contract.retina.frames, len(frames)))
    has_memory = message.HasField("memory")
    return State(
        index=message.index,
        streak=message.streak,
        newest=_sensed(message.newest, frames) if message.HasField("newest") else None,
        frames=frames,
        fault=message.fault,
        memory=_values(message.memory.now, contract) if has_memory else None,
        following=_values(message.memory.next, contract) if has_memory else None,
        hold=_held(message.hold, contract) if message.HasField("hold") else None,
        stopped=message.stopped,
        source=_bound(message.source) if message.HasField("source") else None,
        ranges=_ranges(message),
        moving=_moving(message.moving) if message.HasField("moving") else None,
        backlog=_waited(message.backlog) if message.HasField("backlog") else NO_LAG,
        still=_unchanged(message.still) if message.HasField("still") else MOVING,
        serving=_served(message.serving) if message.HasField("serving") else SINCE_THE_START,
        drove=message.drove,
    )


def _accepted(newest: Sensed | None) -> pb.Accepted | None:
    if newest is None:
        return None
    return pb.Accepted(
        sequence=newest.stamp.sequence,
        source_time_ns=newest.stamp.time_ns,
        sender=newest.stamp.sender,
        received_ns=newest.received_ns,
        scan=None if newest.scan is None else _swept(newest.scan),
    )


def _ranged(newest: Ranged) -> pb.Accepted:
    return pb.Accepted(
        sequence=newest.stamp.sequence,
        source_time_ns=newest.stamp.time_ns,
        sender=newest.stamp.sender,
        received_ns=newest.received_ns,
        scan=_swept(newest.scan),
    )


def _told(moving: Moving) -> pb.Moving:
    return pb.Moving(twist=moving.twist, commanded=moving.commanded, at_ns=moving.at_ns)


def _moving(moving: pb.Moving) -> Moving:
    if not len(moving.twist) == len(moving.commanded) == len(STILL):
        raise LogError(_unfit("speeds of a motion", len(STILL), len(moving.twist)))
    (linear, lateral, angular), told = moving.twist, moving.commanded
    return Moving((linear, lateral, angular), (told[0], told[1], told[2]), moving.at_ns)


def _swept(scan: Scan) -> pb.AcceptedScan:
    return pb.AcceptedScan(
        start_rad=scan.start_rad,
        end_rad=scan.end_rad,
        ranges_m=scan.ranges_m.tolist(),
        x_m=scan.x_m,
        y_m=scan.y_m,
    )


def _backlog(backlog: Lag) -> pb.Backlog | None:
    if backlog == NO_LAG:
        return None
    known = backlog.least
    return pb.Backlog(
        behind_ns=backlog.behind_ns,
        stamp_ns=backlog.stamp_ns,
        received_ns=backlog.received_ns,
        least=None if known is None else _least(known),
    )


def _least(known: LeastDelay) -> pb.LeastDelay:
    return pb.LeastDelay(
        since_ns=known.since_ns, least_ns=known.least_ns, before_ns=known.before_ns
    )


def _waited(said: pb.Backlog) -> Lag:
    least = None
    if said.HasField("least"):
        known = said.least
        least = LeastDelay(known.since_ns, known.least_ns, known.before_ns)
    return Lag(said.behind_ns, said.stamp_ns, said.received_ns, least)


def _still(still: Still) -> pb.Still | None:
    if still == MOVING:
        return None
    return pb.Still(picture=still.picture, driven_ns=still.driven_ns, told_ns=still.told_ns)


def _unchanged(said: pb.Still) -> Still:
    told_ns = said.told_ns if said.HasField("told_ns") else None
    return Still(said.picture, said.driven_ns, told_ns)


def _serving(serving: Serving) -> pb.Serving | None:
    if serving == SINCE_THE_START:
        return None
    return pb.Serving(
        policy_hash=serving.policy_hash,
        former=serving.former,
        pending=serving.pending,
        while_moving=serving.while_moving,
        answered=serving.answered,
    )


def _served(said: pb.Serving) -> Serving:
    return Serving(said.policy_hash, said.former, said.pending, said.while_moving, said.answered)


def _memory(state: State) -> pb.Memory | None:
    if state.following is None:
        return None
    now = [] if state.memory is None else state.memory[0]
    return pb.Memory(now=now, next=state.following[0])


def _hold(hold: Hold) -> pb.Hold:
    return pb.Hold(action=hold.action, since_slot=hold.since_slot)


def _source(source: BoundBody) -> pb.Source:
    return pb.Source(sender=source.sender, heard_ns=source.heard_ns, stranger_ns=source.stranger_ns)


def _bound(source: pb.Source) -> BoundBody:
    stranger_ns = source.stranger_ns if source.HasField("stranger_ns") else None
    return BoundBody(source.sender, source.heard_ns, stranger_ns)


def _sensed(newest: pb.Accepted, frames: tuple[Retina, ...]) -> Sensed:
    if not frames:
        raise LogError(_unfit("frames", "some, with an accepted input", 0))
    stamp = Stamp(newest.sequence, newest.source_time_ns, newest.sender)
    scan = _scan(newest.scan) if newest.HasField("scan") else None
    return Sensed(stamp, newest.received_ns, frames[-1], scan)


def _ranges(message: pb.Keyframe) -> RangeState:
    newest = None
    if message.HasField("ranges"):
        was = message.ranges
        stamp = Stamp(was.sequence, was.source_time_ns, was.sender)
        newest = Ranged(stamp, was.received_ns, _scan(was.scan))
    source = _bound(message.ranges_source) if message.HasField("ranges_source") else None
    late = message.HasField("ranges_backlog")
    backlog = _waited(message.ranges_backlog) if late else NO_LAG
    return RangeState(newest, source, message.ranges_fault, backlog)


def _scan(swept: pb.AcceptedScan) -> Scan:
    ranges_m = np.array(swept.ranges_m, np.float64)
    scan = Scan(swept.start_rad, swept.end_rad, ranges_m, swept.x_m, swept.y_m)
    try:
        check_sweep(scan)
    except UnusableScanError as error:
        raise LogError(_unfit("a scan", "a sweep", str(error))) from None
    return scan


def _retina(data: bytes, contract: PolicyContract) -> Retina:
    if len(data) != contract.retina.size:
        raise LogError(_unfit("bytes of a retina", contract.retina.size, len(data)))
    return np.frombuffer(data, np.uint8).reshape(contract.retina.shape)


def _values(values: object, contract: PolicyContract) -> Memories | None:
    memory: Memories = np.array([list(values)], np.float32)  # type: ignore[call-overload]
    if not memory.size:
        return None
    if memory.size != contract.state.size:
        raise LogError(_unfit("values of a memory", contract.state.size, memory.size))
    return memory


def _held(hold: pb.Hold, contract: PolicyContract) -> Hold:
    if not 0 <= hold.action < len(contract.actions):
        raise LogError(_unfit("a held action", f"0 to {len(contract.actions) - 1}", hold.action))
    return Hold(hold.action, hold.since_slot)


def _unfit(what: str, expected: object, got: object) -> str:
    return f"keyframe: {what}: expected {expected}, got {got}; give the policy of the log"
