import struct
from typing import Any

import pytest

from reflexarc_sim_bridge.body.gate.limits import STANDSTILL, Motion
from reflexarc_sim_bridge.body.ros2.messages import encode_twist, encode_twist_stamped
from reflexarc_sim_bridge.body.ros2.twists import TwistPublisher, moves
from support.ros2 import Time, TwistStamped
from support.sensing import MS
from support.spoken import Spoken

WALL_NS = 1_700_000_000_000_000_000


def publisher(stamped: bool) -> tuple[TwistPublisher, Spoken]:
    spoken: Any = Spoken()
    return TwistPublisher(spoken, stamped, wall_offset=lambda: WALL_NS), spoken


def test_stamped_commands_bear_the_wall_clock_of_the_moment():
    twists, spoken = publisher(stamped=True)
    twists.send(Motion(1.0, 0.5, 0.25), 40 * MS)
    stamped = TwistStamped.deserialize(spoken.said[0][0])
    assert stamped.header.stamp == Time(1_700_000_000, 40 * MS)
    assert stamped.header.frame_id == "base_link"
    assert stamped.twist.linear.x == 1.0
    assert spoken.said[0][1] == WALL_NS + 40 * MS


def test_the_bytes_of_a_standstill():
    # CDR by hand: the envelope of little-endian, and six zeros of 8 bytes.
    twists, spoken = publisher(stamped=False)
    twists.send(STANDSTILL, 0)
    assert spoken.said[0][0] == b"\x00\x01\x00\x00" + struct.pack("<6d", *[0.0] * 6)


@pytest.mark.parametrize("frame", ["", "base_link", "a_frame_of_another_length"])
def test_a_standstill_is_known_by_its_bytes_stamped_or_not(frame: str):
    for motion in (STANDSTILL, Motion(1e-300), Motion(0.0, 0.0, -2.0)):
        expected = not motion.stands
        assert moves(encode_twist(motion)) is expected
        assert moves(encode_twist_stamped(motion, WALL_NS, frame)) is expected
