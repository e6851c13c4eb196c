from collections import Counter
from typing import Any

from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform

from reflexarc_runtime.messages.wire import Message
from reflexarc_sim_bridge.body.ros2.place_relay import (
    MAX_FRAMES,
    READ_A_SECOND,
    TOO_MANY,
    TOO_OFTEN,
    PoseRelay,
    TransformRelay,
)
from support.ros2 import TFMessage, odometry, transform
from support.sensing import MS
from support.spoken import Spoken


def heard(payload: bytes, time_ms: float) -> Message:
    return Message("", payload, "", b"", round(time_ms * MS))


def tf(*names: str) -> bytes:
    return TFMessage([transform(name) for name in names]).serialize()


def names(spoken: Spoken) -> Counter[str]:
    return Counter(FrameTransform.FromString(said).child_frame_id for said, _ in spoken.said)


def test_odometry_at_50_hz_comes_through_and_at_1000_hz_does_not_flood():
    for period_ms, count, expected in ((20.0, 100, 100), (1.0, 2000, 200)):
        spoken: Any = Spoken()
        poses = PoseRelay(spoken)
        for number in range(count):
            poses.hear(heard(odometry().serialize(), number * period_ms))
        assert (poses.poses, len(spoken.said)) == (expected, expected)


def test_what_is_no_odometry_is_counted():
    spoken: Any = Spoken()
    poses = PoseRelay(spoken)
    poses.hear(heard(b"noise", 0))
    poses.hear(heard(b"noise", 20))
    assert poses.refusals.counts == {"no little-endian CDR": 2}
    assert not spoken.said


def test_each_frame_has_a_rate_of_its_own():
    spoken: Any = Spoken()
    transforms = TransformRelay(spoken)
    for number in range(100):  # 100 Hz for a second; the arm once
        transforms.hear(heard(tf("base") if number else tf("base", "arm"), number * 10))
    assert names(spoken) == {"base": 20, "arm": 1}


def test_static_transforms_are_said_again_every_second():
    spoken: Any = Spoken()
    transforms = TransformRelay(spoken)
    transforms.hear_static(heard(tf("laser", "camera"), 100))
    for now_ms in range(0, 3000, 20):
        transforms.repeat(now_ms * MS)
    assert names(spoken) == {"laser": 3, "camera": 3}


def test_a_newer_static_transform_replaces_the_older_one():
    spoken: Any = Spoken()
    transforms = TransformRelay(spoken)
    for x_m in (1.0, 2.0):
        payload = TFMessage([transform("laser", x_m)]).serialize()
        transforms.hear_static(heard(payload, 100))
    for now_ms in (0, 1000):
        transforms.repeat(now_ms * MS)
    places = [FrameTransform.FromString(said).translation.x for said, _ in spoken.said]
    assert places == [1.0, 2.0, 2.0]


def test_frames_beyond_the_first_are_counted_and_the_others_go_on():
    spoken: Any = Spoken()
    transforms = TransformRelay(spoken)
    many = tf(*(f"f{number}" for number in range(MAX_FRAMES + 5)))
    transforms.hear(heard(many, 0))
    transforms.hear_static(heard(many, 1))
    transforms.hear(heard(tf("more", "f0"), 60))
    assert transforms.refusals.counts == {TOO_MANY: 11}
    assert len(spoken.said) == 2 * MAX_FRAMES + 1


def test_a_flood_is_not_even_read():
    spoken: Any = Spoken()
    transforms = TransformRelay(spoken)
    for number in range(3000):  # 2000 Hz for 1.5 s: two seconds have begun
        transforms.hear(heard(b"noise", number * 0.5))
    counts = transforms.refusals.counts
    assert counts == {"no little-endian CDR": 2 * READ_A_SECOND, TOO_OFTEN: 2600}
