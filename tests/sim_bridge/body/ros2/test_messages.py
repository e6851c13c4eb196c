from reflexarc_runtime.contract.motion import Action
from reflexarc_sim_bridge.body.ros2.messages import encode_twist, encode_twist_stamped
from support.ros2 import Header, Time, Twist, TwistStamped, Vector3

LEFT = Action("left", 1.25, 0.5, -0.75)


def test_twists_are_read_by_another_library():
    twist = Twist.deserialize(encode_twist(LEFT))
    assert twist == Twist(Vector3(1.25, 0.5, 0.0), Vector3(0.0, 0.0, -0.75))
    stamped = encode_twist_stamped(LEFT, 1_700_000_000_123_456_789, "base_link")
    expected = Header(Time(1_700_000_000, 123_456_789), "base_link")
    assert TwistStamped.deserialize(stamped) == TwistStamped(expected, twist)


def test_twists_are_the_bytes_that_another_library_writes():
    twist = Twist(Vector3(1.25, 0.5, 0.0), Vector3(0.0, 0.0, -0.75))
    stamped = TwistStamped(Header(Time(5, 6), "base_link"), twist)
    assert encode_twist(LEFT) == twist.serialize()
    assert encode_twist_stamped(LEFT, 5_000_000_006, "base_link") == stamped.serialize()
