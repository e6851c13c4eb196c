"""What each message of a robot becomes in a viewer.

Whatever cannot be decoded becomes nothing: a viewer shows what there is.
"""

import math
from collections.abc import Callable, Iterator

import numpy as np
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneEntityDeletion_pb2 import SceneEntityDeletion
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.message import DecodeError

from reflexarc_logs.viewing import drawings as draw
from reflexarc_logs.viewing.drawings import Drawing
from reflexarc_logs.viewing.scene_shapes import shapes_of
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.decision import Verdict
from reflexarc_runtime.messages import topics
from reflexarc_runtime.sensing.mounting import mount_of, mounted
from reflexarc_runtime.sensing.scan import Scan, UnusableScanError, check_sweep

TRAIL_STEP_M = 0.05
TRAIL_PLACES = 600
"""The last 30 m of the way: they are sent again and again while the robot moves."""
TRAIL_EVERY = 10
"""Poses for one trail."""
RETINA_ASPECT = 8
"""How much wider than high a retina's picture is; one eye's rays are a row of single pixels."""

_CHANNELS = {"mono8": 1, "8UC1": 1, "rgb8": 3, "8UC3": 3, "bgr8": 3, "rgba8": 4}

_Place = tuple[float, float, float]


class Drawer:
    """Turns the messages of one robot into drawings, in the order in which they came."""

    def __init__(self) -> None:
        self.tick: int | None = None
        """Index of the newest tick."""
        self._way: list[_Place] = []
        self._poses = 0
        self._has_pose = False
        self._entities: dict[str, SceneEntity] = {}
        self._said: tuple[int, str] | None = None
        self._by_name: dict[str, Callable[[bytes], Iterator[Drawing]]] = {
            topics.RETINA.name: self._retina,
            topics.SCAN.name: self._scan,
            topics.TICK.name: self._tick,
            topics.POSE.name: self._pose,
            topics.ODOMETRY.name: self._odometry,
            topics.SCENE.name: self._scene,
            topics.LOG.name: self._log,
            topics.MARK.name: self._log,
            topics.CONTACT.name: self._contact,
        }

    def drawings(self, name: str, schema: str, payload: bytes) -> list[Drawing]:
        """What a message becomes.

        Args:
            name: of its topic, without the robot's.
            schema: full name of the message.
            payload: of the message.
        """
        known = self._by_name.get(name)
        try:
            if known is not None:
                return list(known(payload))
            if schema == RawImage.DESCRIPTOR.full_name:
                return list(_image(f"{draw.IMAGES}/{name}", RawImage.FromString(payload)))
            if schema == CompressedImage.DESCRIPTOR.full_name:
                return [_packed(name, CompressedImage.FromString(payload))]
        except (DecodeError, UnusableScanError, ValueError):
            pass
        return []

    def way(self) -> draw.DrawnLine:
        """All of the way."""
        return _line(draw.WAY, self._way)

    def _retina(self, payload: bytes) -> Iterator[Drawing]:
        for picture in _image(draw.RETINA, RawImage.FromString(payload)):
            rows, columns = picture.pixels.shape[:2]
            times = max(1, columns // (RETINA_ASPECT * rows))
            yield draw.DrawnPicture(draw.RETINA, np.repeat(picture.pixels, times, axis=0))

    def _scan(self, payload: bytes) -> Iterator[Drawing]:
        message = LaserScan.FromString(payload)
        scan = Scan(message.start_angle, message.end_angle, np.array(message.ranges, np.float64))
        check_sweep(scan)
        scan = mounted(scan, mount_of(message.pose))
        bearings_rad = scan.start_rad + scan.step_rad * np.arange(len(scan.ranges_m))
        met = np.isfinite(scan.ranges_m) & (scan.ranges_m > 0.0)
        away_m, turn_rad = scan.ranges_m[met], bearings_rad[met]
        x_m, y_m = away_m * np.cos(turn_rad) + scan.x_m, away_m * np.sin(turn_rad) + scan.y_m
        yield draw.DrawnPoints(draw.SCAN, np.stack([x_m, y_m, np.zeros_like(x_m)], axis=1))

    def _tick(self, payload: bytes) -> Iterator[Drawing]:
        decision = pb.Tick.FromString(payload).decision
        self.tick = decision.index
        command = decision.command
        if decision.q_values:
            yield draw.DrawnNumbers(draw.Q_VALUES, tuple(decision.q_values))
        speeds = command.linear_mps, command.lateral_mps, command.angular_radps
        yield draw.DrawnNumbers(draw.COMMAND, speeds)
        if (decision.verdict, decision.reason) != self._said:
            self._said = decision.verdict, decision.reason
            yield _verdict(decision)

    def _pose(self, payload: bytes) -> Iterator[Drawing]:
        self._has_pose = True
        return self._moved(payload)

    def _odometry(self, payload: bytes) -> Iterator[Drawing]:
        """Only where nobody says a better pose."""
        return iter(()) if self._has_pose else self._moved(payload)

    def _moved(self, payload: bytes) -> Iterator[Drawing]:
        pose = PoseInFrame.FromString(payload).pose
        x_m, y_m, turn = pose.position.x, pose.position.y, pose.orientation
        heading_rad = 2.0 * math.atan2(turn.z, turn.w)
        if not all(map(math.isfinite, (x_m, y_m, heading_rad))):
            return
        yield draw.DrawnFrame(draw.ROBOT, x_m, y_m, heading_rad)
        last_x_m, last_y_m, _ = self._way[-1] if self._way else (math.inf, math.inf, 0.0)
        if math.hypot(x_m - last_x_m, y_m - last_y_m) >= TRAIL_STEP_M:
            self._way.append((x_m, y_m, 0.0))
        self._poses += 1
        if self._poses % TRAIL_EVERY == 0:
            yield _line(draw.PATH, self._way[-TRAIL_PLACES:])

    def _scene(self, payload: bytes) -> Iterator[Drawing]:
        update = SceneUpdate.FromString(payload)
        for deletion in update.deletions:
            if deletion.type == SceneEntityDeletion.ALL:
                self._entities.clear()
            self._entities.pop(deletion.id, None)
        self._entities.update({entity.id: entity for entity in update.entities})
        yield from shapes_of(self._entities.values())

    def _log(self, payload: bytes) -> Iterator[Drawing]:
        log = Log.FromString(payload)
        level = (
            "WARN" if log.level == Log.WARNING else "ERROR" if log.level > Log.WARNING else "INFO"
        )
        yield draw.DrawnWords(f"{draw.EVENTS}/log", log.message, level)

    def _contact(self, payload: bytes) -> Iterator[Drawing]:
        contact = pb.Contact.FromString(payload)
        words = f"contact {contact.count} at {contact.x_m:.2f}, {contact.y_m:.2f} m"
        yield draw.DrawnWords(f"{draw.EVENTS}/contact", words, "ERROR")


def _line(place: str, points: list[_Place]) -> draw.DrawnLine:
    return draw.DrawnLine(place, np.array(points, np.float64).reshape(-1, 3))


def _level(level: int) -> str:
    if level < Log.WARNING:
        return "INFO"
    return "WARN" if level == Log.WARNING else "ERROR"


def _verdict(decision: pb.Decision) -> draw.DrawnWords:
    try:
        verdict = Verdict(decision.verdict).name
    except ValueError:  # of a newer version
        verdict = f"verdict {decision.verdict}"
    is_good = decision.verdict == int(Verdict.OK)
    words = f"tick {decision.index}: {verdict}" + (
        f": {decision.reason}" if decision.reason else ""
    )
    return draw.DrawnWords(f"{draw.EVENTS}/verdict", words, "INFO" if is_good else "WARN")


def _image(place: str, image: RawImage) -> Iterator[draw.DrawnPicture]:
    """Its pixels; nothing for an encoding that is not one byte a channel."""
    channels = _CHANNELS.get(image.encoding)
    if channels is None or not image.width or not image.height:
        return
    rows = np.frombuffer(image.data, np.uint8).reshape(image.height, -1)
    pixels = rows[:, : image.width * channels].reshape(image.height, image.width, channels)
    if image.encoding == "bgr8":
        pixels = pixels[:, :, ::-1]
    yield draw.DrawnPicture(place, pixels[:, :, 0] if channels == 1 else pixels)


def _packed(name: str, image: CompressedImage) -> draw.DrawnFile:
    return draw.DrawnFile(f"{draw.IMAGES}/{name}", image.data, f"image/{image.format}")
