"""Writes a log as a bag of ROS 2: a folder with an MCAP file of profile `ros2` and its metadata.

Version 8 of the bag's format, which Humble reads and everything later. Every topic is offered
reliable, so that `ros2 bag play` reaches every subscriber; the fixed transforms stay for late ones.
A bag has one clock: each message's time is its arrival on the wall clock, its header's stamp is the
sender's, brought to the wall clock.
"""

import math
import shutil
from collections import Counter, defaultdict
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.Pose_pb2 import Pose
from foxglove_schemas_protobuf.Quaternion_pb2 import Quaternion
from google.protobuf.message import Message
from rosbags.interfaces import (
    Connection,
    Qos,
    QosDurability,
    QosHistory,
    QosLiveliness,
    QosReliability,
    QosTime,
)
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer

from reflexarc_logs.bags.bag_streams import STATIC
from reflexarc_logs.bags.ros_messages import FORMS, About, RosForm, form_of, scan_frame_of
from reflexarc_logs.reading.reader import Log, Record, decode
from reflexarc_logs.reading.stream_clock import StreamClock
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages.topics import COMMAND, LOG, ODOMETRY
from reflexarc_runtime.ros2.cdr import SECOND_NS, message_types

BAG_VERSION: Final = 8
UNFINISHED = ".exporting"
_USUAL_NAMES = {ODOMETRY.name: "odom", COMMAND.name: "cmd_vel", LOG.name: "rosout"}
"""What ROS calls some of our topics."""
_FOR_EVER = QosTime(9_223_372_036, 854_775_807)
"""RMW_DURATION_INFINITE."""
_CENTRED = (Pose(), Pose(orientation=Quaternion(w=1.0)))
"""A pose that says that the scanner's frame is the one that it names."""


@dataclass
class BagExport:
    """What an export wrote."""

    log: str
    bag: str
    messages: dict[str, int] = field(default_factory=dict)
    """How many each topic of the bag has."""
    left_out: dict[str, int] = field(default_factory=dict)
    """How many messages of the log ROS has no place for, by topic."""


def export_bag(log: Log, out: Path | str) -> BagExport:
    """Write a log as a bag.

    Args:
        log: the log.
        out: the folder to be; it must not exist. After an error it does not.

    Raises:
        LogError: the log cannot be read or has nothing for a bag; `out` exists or cannot be
            written.
    """
    folder = Path(out)
    if folder.exists() or folder.is_symlink():
        raise LogError(f"{out}: exists already; choose another name or remove it")
    place = folder.with_name(folder.name + UNFINISHED)
    try:
        place.mkdir(parents=True)
        report = _Export(log, place / folder.name, BagExport(str(log.path), str(folder))).write()
        (place / folder.name).rename(folder)
    except FileExistsError:
        raise LogError(f"{place}: what made it was killed; remove it") from None
    except OSError as error:
        shutil.rmtree(place, ignore_errors=True)
        raise LogError(f"{out}: cannot be written: {error.strerror}; nothing is left") from None
    except BaseException:
        shutil.rmtree(place, ignore_errors=True)
        raise
    place.rmdir()
    return report


class _Export:
    """One log on its way into a bag."""

    def __init__(self, log: Log, folder: Path, report: BagExport) -> None:
        self._log = log
        self._report = report
        self._writer = Writer(folder, version=BAG_VERSION, storage_plugin=StoragePlugin.MCAP)
        self._writer.set_compression(CompressionMode.STORAGE, CompressionFormat.ZSTD)
        self._writer.set_custom_data("reflexarc.run_id", log.run.run_id)
        self._connections: dict[str, Connection] = {}
        offset_ns = log.run.wall_offset_ns
        self._clocks: dict[str, StreamClock] = defaultdict(lambda: StreamClock(offset_ns))
        self._counts: Counter[str] = Counter()
        self._placed: dict[str, bytes] = {}
        self._farthest_m, self._children = _looked_through(log)

    def write(self) -> BagExport:
        """Write all that ROS has a place for.

        Raises:
            LogError: the log cannot be read, or there is nothing.
        """
        left_out: Counter[str] = Counter()
        with self._writer:
            for record in self._log.records():
                name = _name(self._log, record)
                form = form_of(record.schema, name)
                if form is None:
                    left_out[record.topic] += 1
                    continue
                self._put(_ros_topic(name, form), form, record)
            if not self._counts:
                raise LogError(f"{self._log.path}: it holds nothing that a bag of ROS 2 could")
        self._report.messages = dict(sorted(self._counts.items()))
        self._report.left_out = dict(sorted(left_out.items()))
        return self._report

    def _put(self, topic: str, form: RosForm, record: Record) -> None:
        message = decode(self._log, record, form.kind)
        about = About(
            self._log.run.robot,
            self._clocks[record.topic].wall_ns(_stamp_ns(message, record), record.log_ns),
            _range_max_m(self._farthest_m.get(record.topic, 0.0)),
            self._children.get(getattr(message, "frame_id", ""), ""),
        )
        if isinstance(message, LaserScan) and message.pose not in _CENTRED:
            about = replace(about, scan_frame=f"{topic.strip('/').replace('/', '_')}_frame")
            self._place(message, about, record)
        self._write(topic, form, form.convert(message, about), record.log_ns)

    def _place(self, scan: LaserScan, about: About, record: Record) -> None:
        """Say where a scanner sits, when it is heard first or has moved: ROS scans do not."""
        where = scan_frame_of(scan, about)
        said = where.SerializeToString()
        if self._placed.get(record.topic) != said:
            self._placed[record.topic] = said
            form = FORMS[FrameTransform.DESCRIPTOR.full_name]
            self._write(f"/{STATIC}", form, form.convert(where, about), record.log_ns)

    def _write(self, topic: str, form: RosForm, message: Any, time_ns: int) -> None:
        payload = message_types().serialize_cdr(message, form.type_name)
        self._writer.write(self._connection(topic, form.type_name), time_ns, payload)
        self._counts[topic] += 1

    def _connection(self, topic: str, type_name: str) -> Connection:
        if topic not in self._connections:
            self._connections[topic] = self._writer.add_connection(
                topic,
                type_name,
                typestore=message_types(),
                offered_qos_profiles=[_quality(is_kept=topic.endswith(f"/{STATIC}"))],
            )
        return self._connections[topic]


def _looked_through(log: Log) -> tuple[dict[str, float], dict[str, str]]:
    """The farthest distance of each topic of scans, and which frame moves in which."""
    farthest_m: dict[str, float] = {}
    children: dict[str, str] = {}
    for record in log.records():
        if record.schema == LaserScan.DESCRIPTOR.full_name:
            ranges_m = decode(log, record, LaserScan).ranges
            known = max(filter(math.isfinite, ranges_m), default=0.0)
            farthest_m[record.topic] = max(known, farthest_m.get(record.topic, 0.0))
        elif record.schema == FrameTransform.DESCRIPTOR.full_name:
            transform = decode(log, record, FrameTransform)
            children.setdefault(transform.parent_frame_id, transform.child_frame_id)
    return farthest_m, children


def _range_max_m(farthest_m: float) -> float:
    """A whole number of metres beyond all that was measured: at the limit itself nothing is."""
    return float(math.floor(farthest_m) + 1)


def _stamp_ns(message: Message, record: Record) -> int:
    """When it was by its own words, on its sender's clock."""
    stamp: Any = getattr(message, "timestamp", None)
    if stamp is None or not (stamp.seconds or stamp.nanos):
        return record.publish_ns
    return int(stamp.seconds * SECOND_NS + stamp.nanos)


def _name(log: Log, record: Record) -> str:
    """A topic's name without its robot's; those of other robots keep theirs."""
    return record.topic.removeprefix(f"/{log.run.robot}").removeprefix("/")


def _ros_topic(name: str, form: RosForm) -> str:
    """What a topic is called in ROS: transforms have one place only."""
    if form.kind is FrameTransform:
        return f"/{STATIC}" if name.endswith(STATIC) else "/tf"
    return f"/{_USUAL_NAMES.get(name, name)}"


def _quality(*, is_kept: bool) -> Qos:
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=100 if is_kept else 10,
        reliability=QosReliability.RELIABLE,
        durability=QosDurability.TRANSIENT_LOCAL if is_kept else QosDurability.VOLATILE,
        deadline=_FOR_EVER,
        lifespan=_FOR_EVER,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=_FOR_EVER,
        avoid_ros_namespace_conventions=False,
    )
