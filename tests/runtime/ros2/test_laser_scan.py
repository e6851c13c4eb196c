import contextlib
import math
import struct

import numpy as np
import pytest
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan as FoxgloveScan
from hypothesis import example, given
from hypothesis import strategies as st
from pycdr2 import Endianness

from reflexarc_runtime.contract.eye import BeamRule, RetinaSpec
from reflexarc_runtime.ros2.cdr import UnusableMessageError
from reflexarc_runtime.ros2.laser_scan import MAX_BEAMS, decode_scan, encode_scan
from reflexarc_runtime.sensing.retina import retina_from_scan
from support.ros2 import Header, Time, Twist, Vector3, laser_scan

MOTION = Twist(Vector3(1.25, 0.5, 0.0), Vector3(0.0, 0.0, -0.75))
GOOD = laser_scan([1.0, 2.0, 3.0]).serialize()

floats32 = st.floats(width=32, allow_nan=True, allow_infinity=True)


@given(
    st.lists(floats32, min_size=2, max_size=40),
    st.floats(-7, 7, width=32),
    st.floats(2**-10, 0.125, width=32),
    st.text(max_size=9).filter(lambda text: "\0" not in text),
)
def test_a_scan_by_another_library_comes_through(
    ranges_m: list[float], start_rad: float, step_rad: float, frame: str
):
    sent = laser_scan(ranges_m, start_rad=start_rad, step_rad=step_rad, limits_m=(0.0, math.inf))
    sent.header = Header(Time(1_700_000_000, 123_456_789), frame)
    got = decode_scan(sent.serialize())
    assert (got.stamp_ns, got.frame_id) == (1_700_000_000_123_456_789, frame)
    assert got.sweep.start_rad == start_rad
    assert got.sweep.step_rad == pytest.approx(step_rad, rel=1e-9)
    known = np.array(ranges_m, np.float64)
    known[(known < 0) & (known > -math.inf)] = math.nan
    assert np.array_equal(got.sweep.ranges_m, known, equal_nan=True)


def test_ranges_outside_the_limits_are_unknown_or_free():
    nan, inf = math.nan, math.inf
    ranges_m = [0.0, 0.25, 0.5, 2.0, 4.0, 4.5, inf, -inf, nan, -1.0]
    expected = [0.0, -inf, 0.5, 2.0, inf, inf, inf, -inf, nan, nan]
    got = decode_scan(laser_scan(ranges_m, limits_m=(0.5, 4.0)).serialize()).sweep.ranges_m
    assert np.array_equal(got, expected, equal_nan=True)


def test_clockwise_and_counter_clockwise_scans_of_one_room_give_one_retina():
    ranges_m = [0.5 + 0.01 * beam for beam in range(181)]
    there = laser_scan(ranges_m, start_rad=-math.pi / 2, step_rad=math.pi / 180)
    back = laser_scan(ranges_m[::-1], start_rad=math.pi / 2, step_rad=-math.pi / 180)
    spec = RetinaSpec(rays=17, range_m=5.0)
    sweeps = [decode_scan(scan.serialize()).sweep for scan in (there, back)]
    assert np.array_equal(*[sweep.ranges_m for sweep in sweeps])
    assert np.array_equal(*[retina_from_scan(sweep, spec) for sweep in sweeps])
    assert sweeps[1].start_rad == pytest.approx(-math.pi / 2, abs=1e-5)


def test_a_disc_on_the_left_is_on_the_left_of_the_retina():
    bearings = [-math.pi / 2 + beam * math.pi / 180 for beam in range(181)]
    ranges_m = [1.0 if 0.5 < bearing < 0.9 else math.inf for bearing in bearings]
    got = decode_scan(laser_scan(ranges_m, step_rad=math.pi / 180).serialize())
    retina = retina_from_scan(got.sweep, RetinaSpec(rays=16, beams=BeamRule.SECTOR_MINIMUM))[
        0, :, 0
    ]
    # The sector of ray i ends at π (0.5 − i / 16): 0.98, 0.79, 0.59 and 0.39 rad for 3, 4, 5 and 6.
    assert np.flatnonzero(retina).tolist() == [3, 4, 5]


def test_angle_max_is_not_believed():
    scan = laser_scan([1.0, 2.0, 3.0], step_rad=0.5)
    scan.angle_max = 99.0
    assert decode_scan(scan.serialize()).sweep.step_rad == 0.5


def test_a_scan_goes_out_as_foxglove_laser_scan():
    sent = laser_scan([1.0, math.inf, 0.0], stamp=Time(-1, 999_999_999))
    message = FoxgloveScan.FromString(encode_scan(decode_scan(sent.serialize())))
    assert (message.timestamp.seconds, message.timestamp.nanos) == (-1, 999_999_999)
    assert message.frame_id == "laser"
    assert message.start_angle == pytest.approx(-math.pi / 2, abs=1e-6)
    assert message.end_angle == pytest.approx(math.pi / 2, abs=1e-6)
    assert list(message.ranges)[:2] == [1.0, math.inf]
    assert message.ranges[2] == 0.0  # unknown, too


def scan_with(**fields: float) -> bytes:
    scan = laser_scan([1.0, 2.0, 3.0])
    for name, value in fields.items():
        setattr(scan, name, value)
    return scan.serialize()


def with_count(count: int) -> bytes:
    """A good scan whose number of ranges is another."""
    return GOOD.replace(struct.pack("<I3f", 3, 1, 2, 3), struct.pack("<I3f", count, 1, 2, 3))


UNUSABLE: dict[str, tuple[bytes, str]] = {
    "nothing": (b"", "little-endian"),
    "too short": (GOOD[:3], "little-endian"),
    "big-endian": (laser_scan([1.0, 2.0]).serialize(endianness=Endianness.Big), "little-endian"),
    "a parameter list": (b"\x00\x03" + GOOD[2:], "little-endian"),
    "XCDR2": (laser_scan([1.0, 2.0]).serialize(use_version_2=True), "little-endian"),
    "an envelope alone": (GOOD[:4], "no sensor_msgs/msg/LaserScan"),
    "cut off": (GOOD[:-6], "no sensor_msgs/msg/LaserScan"),
    "with a tail": (GOOD + bytes(8), "no sensor_msgs/msg/LaserScan"),
    "another message": (MOTION.serialize(), "no sensor_msgs/msg/LaserScan"),
    "four billion beams": (with_count(2**32 - 1), "no sensor_msgs/msg/LaserScan"),
    "one beam more": (with_count(5), "no sensor_msgs/msg/LaserScan"),
    "more than 1 MiB": (GOOD + bytes(1 << 20), "more than 1 MiB"),
    "too many beams": (laser_scan([1.0] * (MAX_BEAMS + 1)).serialize(), "beams"),
    "no beam": (laser_scan([]).serialize(), "beams"),
    "one beam": (laser_scan([1.0]).serialize(), "beams"),
    "start is NaN": (scan_with(angle_min=math.nan), "angles"),
    "step is NaN": (scan_with(angle_increment=math.nan), "angles"),
    "step is infinite": (scan_with(angle_increment=math.inf), "angles"),
    "step is zero": (scan_with(angle_increment=0.0), "angles"),
    "limit is NaN": (scan_with(range_max=math.nan), "range_m"),
}


@pytest.mark.parametrize("name", list(UNUSABLE))
def test_what_is_no_scan_is_refused_with_its_reason(name: str):
    payload, reason = UNUSABLE[name]
    with pytest.raises(UnusableMessageError, match=reason):
        decode_scan(payload)


@given(st.binary(max_size=200))
def test_noise_is_a_scan_or_is_refused(noise: bytes):
    decoded_or_refused(b"\x00\x01\x00\x00" + noise)


@given(st.integers(0, len(GOOD) - 1), st.binary(min_size=1, max_size=8))
@example(place=62, damage=b"\x81\x7f")  # makes a range a signalling NaN
def test_a_damaged_scan_is_a_scan_or_is_refused(place: int, damage: bytes):
    decoded_or_refused(GOOD[:place] + damage + GOOD[place + len(damage) :])


def decoded_or_refused(payload: bytes) -> None:
    with contextlib.suppress(UnusableMessageError):
        encode_scan(decode_scan(payload))


def test_the_scans_of_these_tests_have_the_layout_of_the_definition():
    # By hand: envelope, stamp, "laser" with its length, padding, 7 floats, 3 ranges, no intensity.
    assert len(GOOD) == 4 + 8 + (4 + 6) + 2 + 7 * 4 + (4 + 3 * 4) + 4
