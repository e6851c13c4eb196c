"""How a scanner sits, as `foxglove.LaserScan.pose` or a flag says it: retinas by hand.

A thing 1 m away from 30° to 60° on the left of the scanner, a wall 2 m behind it.
"""

import math

import numpy as np
import pytest
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan

from reflexarc_runtime.contract.eye import BeamRule, RetinaSpec, Shading
from reflexarc_runtime.messages.wire import (
    Message,
    Stamp,
    UnfitError,
    pack_stamp,
    protobuf_encoding,
)
from reflexarc_runtime.sensing.mounting import Mount, Sector, pose_of
from reflexarc_runtime.sensing.retina import retina_from_scan
from reflexarc_runtime.sensing.scan import Scan
from reflexarc_runtime.sensing.sense_settings import SenseSettings
from reflexarc_runtime.sensing.senses import ScanSense

STRAIGHT = [0, 0, 0, 204, 204, *[0] * 11]
BACKWARDS = [*[0] * 5, *[153] * 6, *[0] * 5]
MIRRORED = STRAIGHT[::-1]


def place() -> LaserScan:
    scan = LaserScan(start_angle=-math.pi, end_angle=math.radians(179))
    for degrees in range(-180, 180):
        thing, wall = 30 <= degrees <= 60, abs(degrees) >= 150
        scan.ranges.append(1.0 if thing else 2.0 if wall else math.inf)
    return scan


def seen(scan: LaserScan, settings: SenseSettings | None = None) -> list[int]:
    sense = ScanSense(RetinaSpec(), settings or SenseSettings())
    encoding = protobuf_encoding("foxglove.LaserScan")
    payload, stamp = scan.SerializeToString(), pack_stamp(Stamp(0, 0))
    values: list[int] = (
        sense.decode(Message("robot0/scan", payload, encoding, stamp, 0)).retina.ravel().tolist()
    )
    return values


@pytest.mark.parametrize(
    ("mount", "expected"),
    [
        (Mount(), STRAIGHT),
        (Mount(yaw_rad=math.pi), BACKWARDS),
        (Mount(yaw_rad=-math.pi), BACKWARDS),
        (Mount(yaw_rad=5 * math.pi), BACKWARDS),
        (Mount(upside_down=True), MIRRORED),
        # Upside down and backwards: what it sees at 150° to 180° lies ahead, mirrored or not.
        (Mount(yaw_rad=math.pi, upside_down=True), BACKWARDS),
    ],
)
def test_a_pose_and_a_flag_turn_the_picture(mount: Mount, expected: list[int]):
    posed = place()
    posed.pose.CopyFrom(pose_of(mount))
    assert seen(posed) == expected
    assert seen(place(), SenseSettings(mount=mount)) == expected


def test_a_flag_goes_before_a_pose():
    posed = place()
    posed.pose.CopyFrom(pose_of(Mount(yaw_rad=math.pi)))
    assert seen(posed, SenseSettings(mount=Mount())) == STRAIGHT


def test_half_a_turn_about_the_scanner_s_own_axis_is_a_quaternion_by_hand():
    posed = place()
    posed.pose.orientation.z = -2.0  # not of length 1
    assert seen(posed) == BACKWARDS
    posed.pose.orientation.z, posed.pose.orientation.x = 0.0, 1.0
    assert seen(posed) == MIRRORED


@pytest.mark.parametrize(
    ("start", "end"), [(-180.0, 179.0), (170.0, 176.0), (20.0, 23.0), (-200.0, -196.9)]
)
def test_degrees_are_refused_and_the_flag_is_named(start: float, end: float):
    scan = place()
    scan.start_angle, scan.end_angle = start, end
    with pytest.raises(UnfitError, match="--angles degrees"):
        seen(scan)


@pytest.mark.parametrize("place_m", [(12.0, 4.0), (0.0, -11.0), (1e300, 0.0)])
def test_a_pose_on_a_map_is_refused(place_m: tuple[float, float]):
    scan = place()
    scan.pose.position.x, scan.pose.position.y = place_m
    scan.pose.orientation.w = 1.0
    with pytest.raises(UnfitError, match="from the robot's centre; --mount"):
        seen(scan)
    assert seen(scan, SenseSettings(mount=Mount())) == STRAIGHT


@pytest.mark.parametrize("tilt_deg", [16, 90, 164])
def test_a_scanner_that_looks_at_the_floor_is_refused(tilt_deg: float):
    scan = place()
    half_rad = math.radians(tilt_deg) / 2
    scan.pose.orientation.y, scan.pose.orientation.w = math.sin(half_rad), math.cos(half_rad)
    with pytest.raises(UnfitError, match=f"tilted by {tilt_deg}°"):
        seen(scan)


def test_a_thing_too_near_a_shifted_scanner_is_ahead_where_the_scanner_is():
    scan = place()
    scan.ranges[:] = [math.inf] * 360
    scan.ranges[270] = -math.inf  # to the left of a scanner 0.3 m ahead
    retina = seen(scan, SenseSettings(mount=Mount(x_m=0.3)))
    # Somewhere from (0.3, 0) to the left: from 0° to 90° as the robot's centre sees it. Straight
    # ahead is the line between two sectors, and belongs to both.
    assert retina == [255] * 9 + [0] * 7


def test_what_the_robot_sees_of_itself_is_not_free():
    scan = place()
    for beam in range(170, 190):  # a post 0.1 m ahead
        scan.ranges[beam] = 0.1
    post = Sector(math.radians(-11), math.radians(11))
    retina = seen(scan, SenseSettings(ignored=(post,)))
    assert retina == [0, 0, 0, 204, 204, 0, 0, 255, 255, *[0] * 7]


def test_a_beam_that_meets_nothing_is_dark_where_it_leads_through_the_robot_s_centre():
    beams = np.full(2, math.inf)  # at −45° and 45°, from behind on the right: the left one does
    scan = Scan(-math.pi / 4, math.pi / 4, beams, x_m=-0.15, y_m=-0.15)
    eye = RetinaSpec(
        range_m=12.0, shading=Shading.COLOUR, fov_rad=1.5, beams=BeamRule.SECTOR_MINIMUM
    )
    assert retina_from_scan(scan, eye).max() == 0
