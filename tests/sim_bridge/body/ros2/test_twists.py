import struct
from typing import Any

import pytest

from reflexarc_sim_bridge.body.gate.limits import STANDSTILL, Motion
from reflexarc_sim_bridge.body.ros2.messages import encode_twist, encode_twist_stamped
from reflexarc_sim_bridge.body.ros2.stamps import ScanStamps, Stamper, StampRule
from reflexarc_sim_bridge.body.ros2.twists import TwistPublisher, moves
from support.ros2 import Time, TwistStamped
from support.sensing import MS
from support.spoken import Spoken

WALL_NS = 1_700_000_000_000_000_000


def publisher(rule: StampRule | None) -> tuple[TwistPublisher, Spoken]:
    """It has heard a scan at 20 ms, of second 7 on the robot's clock."""
    spoken: Any = Spoken()
    scans = ScanStamps()
    scans.note(20 * MS, 7_000_000_000)
    stamper = None if rule is None else Stamper(rule, lambda: WALL_NS, scans)
    return TwistPublisher(spoken, stamper, wall_offset=lambda: WALL_NS), spoken


@pytest.mark.parametrize(
    ("rule", "expected"),
    [
        (StampRule.WALL, Time(1_700_000_000, 40 * MS)),
        (StampRule.SCAN, Time(7, 0)),
        (StampRule.ZERO, Time(0, 0)),
    ],
)
def test_stamped_commands_bear_what_the_rule_says(rule: StampRule, expected: Time):
    twists, spoken = publisher(rule)
    twists.send(Motion(1.0, 0.5, 0.25), 40 * MS, source_ns=20 * MS)
    stamped = TwistStamped.deserialize(spoken.said[0][0])
    assert stamped.header.stamp == expected
    assert stamped.header.frame_id == "base_link"
    assert stamped.twist.linear.x == 1.0
    assert spoken.said[0][1] == WALL_NS + 40 * MS


def test_the_bytes_of_a_standstill():
    # CDR by hand: the envelope of little-endian, and six zeros of 8 bytes.
    twists, spoken = publisher(None)
    twists.send(STANDSTILL, 0)
    assert spoken.said[0][0] == b"\x00\x01\x00\x00" + struct.pack("<6d", *[0.0] * 6)


@pytest.mark.parametrize("frame", ["", "base_link", "a_frame_of_another_length"])
def test_a_standstill_is_known_by_its_bytes_stamped_or_not(frame: str):
    for motion in (STANDSTILL, Motion(1e-300), Motion(0.0, 0.0, -2.0)):
        expected = not motion.stands
        assert moves(encode_twist(motion)) is expected
        assert moves(encode_twist_stamped(motion, WALL_NS, frame)) is expected
