"""Scans as the drivers of real scanners write them, all the way to a retina.

One place by all of them: a thing 1 m away from 30° to 60° on the left, a wall 2 m behind. Where a
driver's sources were looked at, `docs/senses.md` names them.
"""

import math
from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from reflexarc_runtime.contract.eye import BeamRule, RetinaSpec
from reflexarc_runtime.messages.wire import (
    Message,
    Stamp,
    UnfitError,
    pack_stamp,
    protobuf_encoding,
)
from reflexarc_runtime.ros2.cdr import UnusableMessageError
from reflexarc_runtime.ros2.laser_scan import RosScanner, decode_scan, encode_scan
from reflexarc_runtime.sensing.range_meaning import Angles, RangeMeaning
from reflexarc_runtime.sensing.senses import ScanSense
from support.ros2 import laser_scan

NAN, INF, TURN = math.nan, math.inf, 2 * math.pi
STANDARD = RangeMeaning()
ZERO, IS_NAN = RangeMeaning(("zero",)), RangeMeaning(("nan",))
DARK_ELSEWHERE = [0, 0, 0, 204, 204, *[0] * 11]
"""Nearness at 1 m of 5: 255 · 4/5; rays 3 and 4 of 16 look to 50.6° and 39.4°."""


@dataclass(frozen=True)
class Driver:
    """How a driver writes the place."""

    start_rad: float
    step_rad: float
    beams: int
    limits_m: tuple[float, float]
    nothing: float
    thing_m: float = 1.0
    too_near: float = NAN
    """What it writes for something nearer than it can measure; NaN: see `nothing`."""
    flags: RangeMeaning = field(default_factory=RangeMeaning)
    """What must be said beside; without it the scan is refused."""
    reason: str = "--no-return"
    """What the refusal names."""

    def payload(self, thing_m: float | None = None) -> bytes:
        """The place as `sensor_msgs/LaserScan`; beams half-way to a border count as inside it."""
        met_m = self.thing_m if thing_m is None else thing_m
        ranges_m = []
        for beam in range(self.beams):
            degrees = math.degrees(self.start_rad + beam * self.step_rad)
            bearing = (degrees + 180) % 360 - 180
            is_thing, is_wall = 29.9 < bearing < 60.1, abs(bearing) > 149.9
            ranges_m.append(met_m if is_thing else 2.0 if is_wall else self.nothing)
        scale = 1.0 if self.flags.angles is Angles.RADIANS else 180 / math.pi
        scan = laser_scan(
            ranges_m,
            start_rad=scale * self.start_rad,
            step_rad=scale * self.step_rad,
            limits_m=self.limits_m,
        )
        return bytes(scan.serialize())


TURN_IN_360 = (-math.pi, math.radians(1), 360)
DRIVERS = {
    "rplidar_ros": Driver(math.radians(-179), TURN * 359 / 360 / 719, 720, (0.15, 12.0), INF),
    "ydlidar_ros2_driver": Driver(-math.pi, TURN / 504, 505, (0.1, 12.0), 0.0, flags=ZERO),
    "ldlidar_stl_ros2": Driver(0.0, TURN / 449, 450, (0.02, 25.0), NAN, flags=IS_NAN),
    "urg_node": Driver(
        math.radians(-120), math.radians(240) / 682, 683, (0.02, 5.6), NAN, flags=IS_NAN
    ),
    "sick_scan_xd": Driver(
        math.radians(-137.5), math.radians(275) / 1100, 1101, (0.05, 25.04), 0.0, flags=ZERO
    ),
    "hls_lfcd_lds_driver": Driver(0.0, TURN / 360, 360, (0.12, 3.5), 0.0, flags=ZERO),
    "hls_lfcd_lds_driver, in order of time": Driver(
        0.0, -TURN / 360, 360, (0.12, 3.5), 0.0, flags=ZERO
    ),
    "velodyne_laserscan": Driver(-math.pi, 0.007, 897, (0.0, 200.0), INF),
    "pointcloud_to_laserscan": Driver(*TURN_IN_360, (0.0, INF), INF),
    "pointcloud_to_laserscan, use_inf false": Driver(*TURN_IN_360, (0.0, 10.0), 11.0),
    "gz-sensors": Driver(*TURN_IN_360, (0.12, 10.0), INF, too_near=-INF),
    "no return is range_max": Driver(*TURN_IN_360, (0.1, 4.0), 4.0),
    "no return is 8.19": Driver(
        *TURN_IN_360, (0.1, 80.0), 8.19, flags=RangeMeaning(("8.19",)), reason=""
    ),
    "limits wrong": Driver(
        *TURN_IN_360, (0.1, 0.0), INF, flags=RangeMeaning(max_m=12.0), reason="--range-max"
    ),
    "limits negative": Driver(
        *TURN_IN_360, (0.1, -1.0), INF, flags=RangeMeaning(max_m=12.0), reason="--range-max"
    ),
    "degrees": Driver(
        *TURN_IN_360,
        (0.1, 12.0),
        INF,
        flags=RangeMeaning(angles=Angles.DEGREES),
        reason="turns.*--angles degrees",
    ),
}
EYE = RetinaSpec()


def seen(payload: bytes, meaning: RangeMeaning, spec: RetinaSpec = EYE) -> list[int]:
    """Through the bridge and the runtime's own sense."""
    passed = encode_scan(decode_scan(payload, RosScanner(meaning)))
    sense = ScanSense(spec)
    encoding = protobuf_encoding("foxglove.LaserScan")
    sensed = sense.decode(Message("robot0/scan", passed, encoding, pack_stamp(Stamp(0, 0)), 0))
    values: list[int] = sensed.retina.ravel().tolist()
    return values


@pytest.mark.parametrize("name", list(DRIVERS))
@pytest.mark.parametrize("rule", list(BeamRule))
def test_every_driver_shows_the_same_place(name: str, rule: BeamRule):
    driver = DRIVERS[name]
    values = seen(driver.payload(), driver.flags, replace(EYE, beams=rule))
    if rule is BeamRule.NEAREST_BEAM:
        assert values == DARK_ELSEWHERE
    else:  # the thing's edges, at 30° and 60°, lie in the sectors of rays 2 and 5
        assert values[3:5] == [204, 204]
        assert values[:2] == [0, 0]
        assert values[6:] == [0] * 10


@pytest.mark.parametrize(
    "name", [name for name, d in DRIVERS.items() if d.reason and d.flags != STANDARD]
)
def test_without_its_flag_a_driver_is_refused_and_the_reason_names_the_flag(name: str):
    driver = DRIVERS[name]
    with pytest.raises((UnusableMessageError, UnfitError), match=driver.reason):
        seen(driver.payload(), STANDARD)


@pytest.mark.parametrize("name", [name for name, d in DRIVERS.items() if d.limits_m[0] > 0.01])
def test_what_is_nearer_than_a_driver_measures_is_as_bright_as_can_be(name: str):
    driver = DRIVERS[name]
    below_m = 0.5 * driver.limits_m[0]
    for nearer in (below_m, -INF):
        assert seen(driver.payload(nearer), driver.flags)[3:5] == [255, 255]


def test_a_least_range_beyond_the_thing_does_not_hide_it():
    scan = replace(DRIVERS["gz-sensors"], limits_m=(1.5, 12.0))
    assert seen(scan.payload(), STANDARD)[3:5] == [255, 255]


def test_a_camera_s_depth_is_narrower_than_the_eye_and_refused():
    half_rad = math.radians(29)
    camera = Driver(-half_rad, 2 * half_rad / 639, 640, (0.45, 10.0), NAN, flags=IS_NAN)
    with pytest.raises(UnfitError, match="do not cover the field of view"):
        seen(camera.payload(), camera.flags)
    narrow = seen(camera.payload(), camera.flags, replace(EYE, fov_rad=2 * half_rad))
    assert narrow == [0] * 16  # the thing begins at 30°


def test_error_codes_of_a_hokuyo_are_too_near_and_never_free():
    ranges_m = np.full(683, INF)
    ranges_m[300:400] = 0.006
    scan = laser_scan(ranges_m.tolist(), start_rad=-2.09, step_rad=4.18 / 682, limits_m=(0.02, 5.6))
    assert max(seen(bytes(scan.serialize()), STANDARD)) == 255
