"""The drive of a simulated body, as a log tells of it: where it was, and what it was told there.

A look of the body and its pose have one time, on the body's own clock, and a tick names the time of
the look that it decided on. So poses, ticks and contacts pair by that time, in whatever order the
recorder got them.
"""

import math
from dataclasses import dataclass, field

from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame

from reflexarc_logs.reading.reader import Log, Record, decode
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.decision import Command
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages.body_info import BodyInfo, decode_body
from reflexarc_runtime.messages.codec import decode_command
from reflexarc_runtime.messages.topics import BODY, BODY_NODE, CONTACT, POSE, STATUS, TICK
from reflexarc_runtime.serving.swapping import says_rolled_back
from reflexarc_sim_bridge.body.body import BodyPose
from reflexarc_sim_bridge.body.ride import HandOver

FARTHEST_M = 1e6
"""No simulated body drives farther in a log; what is, is no place."""


@dataclass(frozen=True)
class ToldThere:
    """A tick that decided on a look of the body."""

    tick: int
    now_ns: int
    action: int
    command: Command | None
    policy_hash: str
    """Of the policy that decided it."""
    began_anew: bool
    """Whether one had just failed, and this one decided that same tick."""


@dataclass
class RecordedDrive:
    """A drive, pose by pose."""

    info: BodyInfo
    is_lockstep: bool
    checks: bool = False
    """Whether the body looks for itself whether a commanded way is free."""
    times_ns: list[int] = field(default_factory=list)
    """On the body's clock, increasing."""
    places: list[BodyPose] = field(default_factory=list)
    steps: list[int] = field(default_factory=list)
    """How many the body had made."""
    told: dict[int, ToldThere] = field(default_factory=dict)
    """By the time of the look."""
    contacts: list[int] = field(default_factory=list)
    """Indices of the poses behind which a step ended in a contact, increasing."""

    def hand_overs(self, first: str) -> list[HandOver]:
        """Who decided from which look on, where it was another one than before.

        Args:
            first: hash of the policy that the log names.
        """
        found, before = list[HandOver](), first
        for time_ns, told in sorted(self.told.items(), key=lambda each: each[1].tick):
            if told.policy_hash != before or told.began_anew:
                former = "" if told.began_anew else before
                found.append(HandOver(time_ns, told.policy_hash, former))
                before = told.policy_hash
        return found

    def tick_at(self, pose: int) -> int:
        """The tick that decided there, or the last one before."""
        last = min(pose, len(self.times_ns) - 1)
        for k in range(last, -1, -1):
            if (told := self.told.get(self.times_ns[k])) is not None:
                return told.tick + pose - k
        return pose

    def pose_of_tick(self, tick: int) -> int:
        """The pose that a tick decided on.

        Raises:
            LogError: there is no such tick, or it decided on none.
        """
        for k, time_ns in enumerate(self.times_ns):
            told = self.told.get(time_ns)
            if told is not None and told.tick == tick:
                return k
        raise LogError(f"--at {tick}: expected a tick that decided on a look, found none")


def recorded_drive(log: Log) -> RecordedDrive:
    """Read the drive of the robot that a log names.

    Raises:
        LogError: it does not say which world the body was in, or there are no poses of it.
    """
    reading = _Reading(log)
    for record in log.records(*reading.topics):
        reading.take(record)
    return reading.drive()


class _Reading:
    """A log while it is read."""

    def __init__(self, log: Log) -> None:
        self._log = log
        takers = {
            BODY: self._body,
            POSE: self._pose,
            TICK: self._tick,
            CONTACT: self._contact,
            STATUS: self._status,
        }
        self._takers = {log.topic(topic.name): take for topic, take in takers.items()}
        self._infos = set[bytes]()
        self._poses: dict[int, tuple[int, BodyPose]] = {}
        self._told: dict[int, ToldThere] = {}
        self._touched_ns = list[int]()
        self._checks = False

    @property
    def topics(self) -> tuple[str, ...]:
        return tuple(self._takers)

    def take(self, record: Record) -> None:
        self._takers[record.topic](record)

    def drive(self) -> RecordedDrive:
        info, log = self._info(), self._log
        is_lockstep = log.run.clock == "lockstep"
        if not self._poses:
            raise LogError(f"{log.path}: expected the poses of its body, found none")
        times_ns = sorted(self._poses)
        index_of = {time_ns: k for k, time_ns in enumerate(times_ns)}
        return RecordedDrive(
            info,
            is_lockstep,
            self._checks,
            times_ns,
            [self._poses[time_ns][1] for time_ns in times_ns],
            [self._steps(time_ns, info, is_lockstep) for time_ns in times_ns],
            self._told,
            sorted(index_of[at] - 1 for at in self._touched_ns if index_of.get(at)),
        )

    def _steps(self, time_ns: int, info: BodyInfo, is_lockstep: bool) -> int:
        """In lockstep time is counted in steps; else a body moves, and then says its pose."""
        if is_lockstep:
            return round(time_ns / (info.step_s * 1e9))
        return self._poses[time_ns][0] + 1

    def _info(self) -> BodyInfo:
        infos, path = [decode_body(payload) for payload in self._infos], self._log.path
        if not infos:
            raise LogError(f"{path}: expected what a body says of its world, found nothing")
        info = infos[0]
        if info is None or len(infos) > 1:
            raise LogError(f"{path}: expected one body, found {len(infos)} that differ")
        if not (info.world_text and info.step_s):
            raise LogError(f"{path}: its body was not simulated: no world to build again")
        return info

    def _body(self, record: Record) -> None:
        self._infos.add(record.payload)

    def _pose(self, record: Record) -> None:
        pose = decode(self._log, record, PoseInFrame).pose
        x_m, y_m = pose.position.x, pose.position.y
        heading_rad = 2.0 * math.atan2(pose.orientation.z, pose.orientation.w)
        if abs(x_m) <= FARTHEST_M and abs(y_m) <= FARTHEST_M and math.isfinite(heading_rad):
            place = BodyPose(x_m, y_m, math.remainder(heading_rad, 2.0 * math.pi))
            self._poses[record.publish_ns] = record.sequence, place

    def _tick(self, record: Record) -> None:
        decision = decode(self._log, record, pb.Tick).decision
        if decision.HasField("input"):
            command = decode_command(decision.command.SerializeToString())
            told = ToldThere(
                decision.index,
                decision.now_ns,
                decision.action,
                command,
                decision.policy_hash,
                says_rolled_back(decision.reason),
            )
            self._told[decision.input.source_time_ns] = told

    def _contact(self, record: Record) -> None:
        self._touched_ns.append(record.publish_ns)

    def _status(self, record: Record) -> None:
        status = decode(self._log, record, pb.Status)
        self._checks |= status.node == BODY_NODE and status.guard == "on"
