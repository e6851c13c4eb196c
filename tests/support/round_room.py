"""Logs that pictures and films are made of: a robot that turns in a round room."""

import math
from dataclasses import replace
from pathlib import Path

from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding
from support.policies import exported
from support.recordings import MS, PERIOD_NS, RUN, START_NS, drive

TICKS = 40
ROOM_M = 4.0
"""Distance of the walls of a round room: every beam from its middle is as long."""


def message(topic: str, payload: LaserScan | PoseInFrame | SceneUpdate, slot: int) -> Message:
    received_ns = START_NS + slot * PERIOD_NS - 3 * MS
    return Message(
        f"robot0/{topic}",
        payload.SerializeToString(),
        protobuf_encoding(payload.DESCRIPTOR.full_name),
        pack_stamp(Stamp(slot, received_ns - MS)),
        received_ns,
    )


def scan(length_m: float) -> LaserScan:
    beams = [length_m] * 179 + [math.inf, math.nan]
    return LaserScan(start_angle=-math.pi / 2, end_angle=math.pi / 2, ranges=beams)


def pose(x_m: float, y_m: float, heading_rad: float) -> PoseInFrame:
    pose = PoseInFrame(frame_id="world")
    pose.pose.position.x, pose.pose.position.y = x_m, y_m
    pose.pose.orientation.z = math.sin(heading_rad / 2)
    pose.pose.orientation.w = math.cos(heading_rad / 2)
    return pose


def turning_log(path: Path) -> Path:
    """A log of a robot that turns once around in the middle, at (3, −2), of a round room."""
    contract = PolicyContract(retina=RetinaSpec(rays=8, fov_rad=3.0))
    slots = range(1, TICKS + 1)
    poses = [message("pose", pose(3.0, -2.0, 2 * math.pi * slot / TICKS), slot) for slot in slots]
    drive(
        path,
        exported(contract),
        {slot: [message("scan", scan(ROOM_M), slot)] for slot in slots},
        TICKS,
        run=replace(RUN, input="scan"),
        before=poses,
    )
    return path
