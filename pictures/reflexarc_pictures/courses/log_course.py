"""Makes a course of a log: where the robot was, which obstacles were around it, what it saw.

Poses, scenes, contacts and ticks have times on the recorder's clock; a snapshot takes the last of
each. The log has no distances: if a retina shows nearness and obstacles are white, a value v means
range · (1 − v / 255).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from foxglove_schemas_protobuf.Color_pb2 import Color
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate

from reflexarc_logs.reading.reader import Log
from reflexarc_pictures.courses.course import Course, Snapshot, eye_of
from reflexarc_pictures.log_pictures.decision_strips import BRIGHT
from reflexarc_pictures.log_pictures.drive import JUMP_M
from reflexarc_pictures.log_pictures.logged_poses import Floats, poses_of
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec, Shading
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages.topics import CONTACT, SCENE, TICK
from reflexarc_runtime.messages_pb2 import Tick
from reflexarc_runtime.policy.policy import load_contract
from reflexarc_runtime.sensing.ray_values import FULL_SCALE, ray_bearing_rad
from reflexarc_sim_bridge.worlds.silhouettes import Area, Silhouette, circle, reaches_into

PERIOD_S = 0.1


@dataclass(frozen=True)
class LoggedScenery:
    """The obstacles that the body published, about once a second."""

    times_s: Floats
    """The time of each scene, on the clock of the course: (scenes,)."""
    scenes: Sequence[Sequence[Silhouette]]

    def within(self, area: Area, time_s: float) -> list[Silhouette]:
        """See `Scenery.within`; shows the last scene, and before the first one already that."""
        if not len(self.scenes):
            return []
        last = max(int(np.searchsorted(self.times_s, time_s + 1e-9, side="right")) - 1, 0)
        return [shape for shape in self.scenes[last] if reaches_into(shape.corners_m, area)]


def course_of(log: Log, duration_s: float) -> Course:
    """The first part of a log as a course, from its first pose on.

    Args:
        log: with poses and a policy.
        duration_s: how much of it, if it is as long.

    Raises:
        LogError: it names no policy, has no poses, or is damaged.
    """
    if log.policy is None:
        raise LogError(f"{log.path}: expected the policy of `reflexarc run --record`, found none")
    contract = load_contract(log.policy, bounds=None)
    _, posed_ns, poses = poses_of(log)
    if not len(poses):
        raise LogError(f"{log.path}: a film needs poses, found none; draw it as a picture, *.png")
    end_ns = min(int(posed_ns[-1]), int(posed_ns[0]) + round(duration_s * 1e9))
    times_ns = np.arange(int(posed_ns[0]), end_ns + 1, round(PERIOD_S * 1e9), dtype=np.int64)
    held = poses[_last(posed_ns, times_ns)]
    retinas, contacts = _retinas(log, contract.retina, times_ns), _contacts(log, times_ns)
    spec = contract.retina
    bearings = [ray_bearing_rad(ray, spec.rays, spec.fov_rad) for ray in range(spec.rays)]
    return Course(
        title=log.path.name,
        period_s=PERIOD_S,
        snapshots=[
            Snapshot(x_m, y_m, heading_rad, retina, _reach(retina, spec), met, put)
            for (x_m, y_m, heading_rad), retina, met, put in zip(
                held.tolist(), retinas, contacts, _jumps(held, contract), strict=True
            )
        ],
        eye=eye_of(contract, np.array(bearings)),
        bright=BRIGHT[spec.shading],
        scenery=_scenery(log, int(posed_ns[0])),
    )


def _last(
    known_ns: npt.NDArray[np.int64], times_ns: npt.NDArray[np.int64]
) -> npt.NDArray[np.int64]:
    """Index of the last known time at or before each time; −1 before the first."""
    found: npt.NDArray[np.int64] = np.searchsorted(known_ns, times_ns, side="right") - 1
    return found


def _jumps(held: Floats, contract: PolicyContract) -> list[bool]:
    """Whether the body was placed elsewhere: it cannot drive as far between two snapshots."""
    fastest_mps = max(math.hypot(a.linear_mps, a.lateral_mps) for a in contract.actions)
    far_m = max(2.0 * fastest_mps * PERIOD_S, JUMP_M)
    return [False, *(np.hypot(*np.diff(held[:, :2], axis=0).T) > far_m).tolist()]


def _retinas(
    log: Log, spec: RetinaSpec, times_ns: npt.NDArray[np.int64]
) -> list[npt.NDArray[np.uint8] | None]:
    """The newest retina of the policy at each time; None if the policy was not asked."""
    known_ns, seen = [], list[npt.NDArray[np.uint8] | None]()
    for record, tick in log.messages(log.topic(TICK.name), Tick):
        known_ns.append(record.log_ns)
        stack = np.frombuffer(tick.decision.retina, np.uint8)
        fits = len(stack) == spec.frames * spec.size
        seen.append(stack[-spec.size :].reshape(spec.shape) if fits else None)
    last = _last(np.array(known_ns, np.int64), times_ns).tolist()
    return [seen[k] if k >= 0 else None for k in last]


def _reach(retina: npt.NDArray[np.uint8] | None, spec: RetinaSpec) -> Floats | None:
    if retina is None or spec.shading is not Shading.NEARNESS:
        return None
    nearness = retina[0].max(axis=1).astype(np.float64) / FULL_SCALE
    reach_m: Floats = spec.range_m * (1.0 - nearness)
    return reach_m


def _contacts(log: Log, times_ns: npt.NDArray[np.int64]) -> list[bool]:
    """Whether a contact began since the snapshot before."""
    began = log.messages(log.topic(CONTACT.name), pb.Contact)
    at_ns = np.sort(np.array([record.log_ns for record, _ in began], np.int64))
    so_far = _last(at_ns, times_ns)
    return [False, *(np.diff(so_far) > 0).tolist()]


def _scenery(log: Log, start_ns: int) -> LoggedScenery:
    updates = list(log.messages(log.topic(SCENE.name), SceneUpdate))
    times_s = np.array([record.log_ns - start_ns for record, _ in updates]) * 1e-9
    return LoggedScenery(
        times_s,
        [[s for entity in scene.entities for s in _silhouettes(entity)] for _, scene in updates],
    )


def _silhouettes(entity: SceneEntity) -> list[Silhouette]:
    found = []
    for cube in entity.cubes:
        x, y, signs = (
            cube.pose.position.x,
            cube.pose.position.y,
            [(1, 1), (-1, 1), (-1, -1), (1, -1)],
        )
        half = np.array([cube.size.x, cube.size.y]) / 2
        found.append(Silhouette(np.array([x, y]) + np.array(signs) * half, _paint(cube.color)))
    for disc in entity.cylinders:
        middle = disc.pose.position
        found.append(Silhouette(circle(middle.x, middle.y, disc.size.x / 2), _paint(disc.color)))
    for fan in entity.triangles:  # the first point is its centre
        corners = [(point.x, point.y) for point in fan.points[1:]]
        found.append(Silhouette(np.array(corners), _paint(fan.color)))
    return found


def _paint(colour: Color) -> tuple[float, float, float]:
    return (colour.r, colour.g, colour.b)
