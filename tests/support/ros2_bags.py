"""Bags of ROS 2, of another library's messages: written with rosbags, read with mcap."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from mcap.reader import make_reader
from pycdr2 import IdlStruct
from pycdr2.types import sequence, uint8, uint32
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from support.ros2 import Header, Time

START_NS = 1_700_000_000_000_000_000
TYPES = get_typestore(Stores.ROS2_HUMBLE)

Row = tuple[str, str, int, bytes]
"""Topic, type, time in the bag, payload."""


@dataclass
class Image(IdlStruct, typename="sensor_msgs/Image"):
    header: Header
    height: uint32
    width: uint32
    encoding: str
    is_bigendian: uint8
    step: uint32
    data: sequence[uint8]


@dataclass
class CompressedImage(IdlStruct, typename="sensor_msgs/CompressedImage"):
    header: Header
    format: str
    data: sequence[uint8]


def image(encoding: str = "mono8", *, width: int = 4, height: int = 3, big: int = 0) -> Image:
    pixels = list(range(width * height))
    return Image(Header(frame_id="camera"), height, width, encoding, big, width, pixels)


def write_bag(
    folder: Path, rows: Iterable[Row], plugin: StoragePlugin = StoragePlugin.MCAP
) -> Path:
    """A bag of these messages."""
    with Writer(folder, version=8, storage_plugin=plugin) as writer:
        known = {}
        for topic, kind, time_ns, payload in rows:
            if (topic, kind) not in known:
                known[topic, kind] = writer.add_connection(topic, kind, typestore=TYPES)
            writer.write(known[topic, kind], time_ns, payload)
    return folder


def stamp(time_ns: int) -> Time:
    return Time(*divmod(time_ns, 1_000_000_000))


def read_mcap(path: Path) -> tuple[str, list[tuple[str, str, int, bytes]], dict[str, str]]:
    """Profile of an MCAP file; topic, type, time and payload of its messages; QoS by topic."""
    with path.open("rb") as file:
        reader = make_reader(file)
        rows, qualities = [], {}
        for schema, channel, message in reader.iter_messages():
            assert schema is not None
            assert (schema.encoding, channel.message_encoding) == ("ros2msg", "cdr")
            rows.append((channel.topic, schema.name, message.log_time, message.data))
            qualities[channel.topic] = channel.metadata["offered_qos_profiles"]
        return reader.get_header().profile, rows, qualities


def pixels(message: Image) -> np.ndarray:
    return np.array(message.data, np.uint8)
