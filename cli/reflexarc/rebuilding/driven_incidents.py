"""The moments before incidents of a log, rebuilt, and driven on by a candidate.

A body of the same world and seed is led along the recorded drive: it moves as it was told, and is
put where it was where that is not the same. Two controllers come along, that of the recorded policy
and that of the candidate: they see, and remember, and what they want is not done. Where policies
took over from each other, the recorded one is at each look the one that decided there; a candidate
decides everywhere. Some time before
an incident each is let go from the same moment. The recorded policy is the control: where its way
is not the recorded one up to the incident, the moment is not rebuilt to the bit, and that is said.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from reflexarc.rebuilding.driven_findings import DrivenLog, Tried, WantedDrives
from reflexarc.rebuilding.recorded_drive import RecordedDrive, recorded_drive
from reflexarc_logs.reading.reader import Log, read_log
from reflexarc_logs.replaying.asked_policy import asked_policy, attached_policy
from reflexarc_logs.replaying.serving.served_policies import ServedPolicies
from reflexarc_logs.replaying.stepping import controller_of
from reflexarc_runtime.controller_state import State
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages.topics import RETINA
from reflexarc_runtime.policy.policy import LoadedPolicy
from reflexarc_sim_bridge.body.body import BodyPose, rebuild
from reflexarc_sim_bridge.body.driving_on import DrivenWay, drive_on
from reflexarc_sim_bridge.body.ride import HandOver, Ride

LEAST_LEAD_S = 0.3
"""Who has less time before a contact was put in front of it by the contact before: not tried."""
BEHIND_S = 1.0
"""At least so much is driven behind an incident."""
_SAME_M = 1e-6
_WHOLE = 0.01
"""Ratios of rates that are so near to a whole number are one."""


@dataclass(frozen=True)
class DrivenMoment:
    """A moment of a log that is driven again."""

    pose: int
    """The last one before it."""
    begins: int
    """The pose from which it is driven."""
    is_contact: bool


def drive_incidents(path: Path, policy: Path | None, wanted: WantedDrives) -> DrivenLog:
    """Drive a log's incidents again.

    Args:
        path: a log of a simulated body and its loop.
        policy: the candidate; None: the recorded policy is both.
        wanted: which, and how far.

    Raises:
        LogError: it cannot be rebuilt, with the reason.
        WorldError: the candidate cannot drive in its world.
    """
    log = read_log(path)
    if log.run.recorded_by == "decide":
        raise LogError(
            f"{path}: its ticks were decided afterwards, on a drive of another policy; give the "
            "log of that drive"
        )
    drive, recorded = recorded_drive(log), attached_policy(log)
    candidate = asked_policy(log, policy, None)
    incidents = list(_incidents(drive, wanted))
    least = round(LEAST_LEAD_S / drive.info.step_s)
    late = [one for one in incidents if one.is_contact and one.pose - one.begins < least]
    rides = [
        _ride(log, drive, recorded, is_followed=True),
        _ride(log, drive, candidate, is_followed=policy is None),
    ]
    led = _Led(drive, rides, wanted.driven_s)
    tried = tuple(led.along([one for one in incidents if one not in late]))
    return DrivenLog(
        path,
        "",
        drive.info.world,
        drive.info.seed,
        tried,
        tuple(drive.tick_at(one.pose) for one in late),
        led.off_tick,
        led.off_m,
    )


def _incidents(drive: RecordedDrive, wanted: WantedDrives) -> Iterator[DrivenMoment]:
    poses = drive.contacts[:1] if wanted.first else drive.contacts
    if wanted.at is not None:
        pose = drive.pose_of_tick(wanted.at)
        # A contact may stand in a log behind the tick that its step led to.
        poses = [pose - 1 if pose not in drive.contacts and pose - 1 in drive.contacts else pose]
    before_ns = round(wanted.before_s * 1e9)
    for pose in poses:
        put = max((k + 1 for k in drive.contacts if k < pose), default=0)
        from_ns = drive.times_ns[pose] - before_ns
        begins = next(k for k in range(put, pose + 1) if drive.times_ns[k] >= from_ns)
        yield DrivenMoment(pose, begins, pose in drive.contacts)


def _ride(log: Log, drive: RecordedDrive, policy: LoadedPolicy, *, is_followed: bool) -> Ride:
    """A body of the log's world, under a controller as the log's loop had one.

    With `is_followed` under those of all policies that decided, each where it did.
    """
    if log.run.input != RETINA.name:
        raise LogError(
            f"{log.path}: its loop decided on {log.run.input!r}; a body is built again that sends "
            f"{RETINA.name!r}"
        )
    served = ServedPolicies(log, policy)
    controller, hand_overs = controller_of(log, policy, served), list[HandOver]()
    if is_followed:
        hand_overs = _hand_overs(log, drive, served)
    else:
        controller = controller.at(State())
    if controller.ranges_topic is not None:
        raise LogError(f"{log.path}: its guard had ranges that no simulated body sends")
    rate_hz = 1.0 / drive.info.step_s
    if not drive.is_lockstep and policy.policy_hash == log.run.policy_hash and log.run.rate_hz:
        loop_hz = log.run.rate_hz
    else:
        loop_hz = policy.contract.rate_hz
    every = _every(rate_hz, loop_hz)
    body = rebuild(drive.info, policy.contract, checks=drive.checks, all_round=True)
    return Ride(body, controller, every=every, resends=drive.is_lockstep, hand_overs=hand_overs)


def _hand_overs(log: Log, drive: RecordedDrive, served: ServedPolicies) -> list[HandOver]:
    """Who decided from which look on.

    Raises:
        LogError: one of them is not in the log.
    """
    found = drive.hand_overs(log.run.policy_hash)
    for one in found:
        if served.named(one.policy_hash) is None:
            raise LogError(
                f"{log.path}: expected the policy {one.policy_hash[:12]}, which decided from "
                "there on, found none: its swap, and the file attached beside, are missing"
            )
    return found


def _every(body_hz: float, loop_hz: float) -> int:
    """Steps of the body for one decision.

    Raises:
        LogError: it is no whole number.
    """
    ratio = body_hz / loop_hz
    every = max(1, round(ratio))
    if ratio > 1.0 and abs(ratio - every) > _WHOLE * ratio:
        raise LogError(
            f"the policy decides at {loop_hz:g} Hz, and the body makes {body_hz:g} steps a second: "
            "expected a whole number of steps for a decision"
        )
    return every


class _Led:
    """Rides that are led along a recorded drive, the recorded policy's first."""

    def __init__(self, drive: RecordedDrive, rides: list[Ride], driven_s: float) -> None:
        self._drive, self._rides, self._driven_s = drive, rides, driven_s
        self.off_tick: int | None = None
        self.off_m = 0.0

    def along(self, incidents: list[DrivenMoment]) -> Iterator[Tried]:
        """Lead them as far as is needed; what becomes of each incident."""
        ahead = sorted(incidents, key=lambda one: one.begins)
        for pose in range(max((one.begins for one in ahead), default=-1) + 1):
            self._arrive(pose)
            while ahead and ahead[0].begins == pose:
                yield self._try(ahead.pop(0))
            self._go_on(pose)

    def _arrive(self, pose: int) -> None:
        drive = self._drive
        apart_m, *_ = [ride.put(drive.places[pose], drive.steps[pose]) for ride in self._rides]
        if pose and pose - 1 not in drive.contacts and apart_m > _SAME_M:
            self.off_m = max(self.off_m, apart_m)
            if self.off_tick is None:
                self.off_tick = drive.tick_at(pose)

    def _go_on(self, pose: int) -> None:
        now_ns = self._drive.times_ns[pose]
        for ride in self._rides:
            ride.look(now_ns)
        told = self._drive.told.get(now_ns)
        motion = self._rides[0].told(told.command if told else None, now_ns)
        for ride in self._rides:
            ride.lead(motion)

    def _try(self, incident: DrivenMoment) -> Tried:
        drive, step_s = self._drive, self._drive.info.step_s
        lead_s = (incident.pose - incident.begins) * step_s
        driven_s = max(self._driven_s, lead_s + BEHIND_S)
        recorded, candidate = (
            self._way(ride, incident.begins, round(driven_s / step_s)) for ride in self._rides
        )
        leaves, leaves_m = self._leaves(incident, recorded)
        return Tried(
            tick=drive.tick_at(incident.pose),
            is_contact=incident.is_contact,
            lead_s=lead_s,
            driven_s=driven_s,
            recorded=recorded,
            candidate=candidate,
            recorded_tick=self._tick(incident, recorded),
            candidate_tick=self._tick(incident, candidate),
            leaves_tick=None if leaves is None else drive.tick_at(leaves),
            leaves_m=leaves_m,
        )

    def _way(self, ride: Ride, begins: int, steps: int) -> DrivenWay:
        kept = ride.keep()
        way = drive_on(ride, self._drive.times_ns[begins], steps)
        ride.go_back(kept)
        return way

    def _tick(self, incident: DrivenMoment, way: DrivenWay) -> int | None:
        if way.contact_step is None:
            return None
        return self._drive.tick_at(incident.begins + way.contact_step)

    def _leaves(self, incident: DrivenMoment, way: DrivenWay) -> tuple[int | None, float]:
        """The pose from which a way is not the recorded one, and how far they are apart."""
        first, most_m = None, 0.0
        for pose in range(incident.begins, incident.pose + 1):
            step = pose - incident.begins
            if step >= len(way.places):
                return (pose if first is None else first), most_m
            apart_m = _apart_m(way.places[step], self._drive.places[pose])
            most_m = max(most_m, apart_m)
            if first is None and apart_m > _SAME_M:
                first = pose
        return first, most_m


def _apart_m(one: BodyPose, other: BodyPose) -> float:
    return math.hypot(one.x_m - other.x_m, one.y_m - other.y_m)
