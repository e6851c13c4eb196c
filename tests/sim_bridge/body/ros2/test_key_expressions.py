import pytest
from rosbags.typesys import Stores, get_typestore

from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.messages.wire import Stamp, pack_stamp
from reflexarc_runtime.ros2.ros_types import (
    COMPRESSED_IMAGE,
    IMAGE,
    LASER_SCAN,
    ODOMETRY,
    TF_MESSAGE,
    TWIST,
    TWIST_STAMPED,
    RosType,
)
from reflexarc_sim_bridge.body.ros2.key_expressions import (
    BEST_EFFORT,
    RELIABLE,
    Endpoint,
    Port,
    RosNode,
    check_topic,
    dds_name,
    rmw_endpoint_token,
    rmw_key,
    rmw_node_token,
    ros2dds_key,
)
from reflexarc_sim_bridge.body.ros2.wires import wire_named

ALL = (LASER_SCAN, TWIST, TWIST_STAMPED, ODOMETRY, TF_MESSAGE, IMAGE, COMPRESSED_IMAGE)
STRING = RosType(
    "std_msgs/msg/String", "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
)
LISTENER = RosNode(2, "aac3178e146ba6f1fc6e6a4085e77f21", "listener")
TALKER = RosNode(2, "8b20917502ee955ac4476e0266340d5c", "talker")

# Twist as `ros2 topic info --verbose` prints it in the tutorial "Understanding topics" of ROS 2
# (/turtle1/cmd_vel); TwistStamped as it prints it for the /cmd_vel of ros_gz_bridge on Jazzy;
# LaserScan from the message table of ros-z (github.com/ZettaScaleLabs/ros-z).
PUBLISHED = {
    LASER_SCAN: "RIHS01_64c191398013af96509d518dac71d5164f9382553fce5c1f8cca5be7924bd828",
    TWIST: "RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a",
    TWIST_STAMPED: "RIHS01_5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64",
}


@pytest.mark.parametrize("kind", [*ALL, STRING])
@pytest.mark.parametrize("distribution", [Stores.ROS2_JAZZY, Stores.ROS2_KILTED])
def test_type_hashes_are_those_of_the_definitions(kind: RosType, distribution: Stores):
    assert get_typestore(distribution).hash_rihs01(kind.name) == kind.type_hash


def test_type_hashes_are_those_that_ros_prints():
    assert {kind: kind.type_hash for kind in PUBLISHED} == PUBLISHED


def test_ros2dds_keys_are_names_without_the_leading_slash():
    # zenoh-plugin-ros2dds, ros2_name_to_key_expr: the namespace of the bridge stands before.
    assert ros2dds_key("/cmd_vel") == "cmd_vel"
    assert ros2dds_key("/bot1/cmd_vel") == "bot1/cmd_vel"


def test_rmw_keys_are_those_of_the_design_document():
    # rmw_zenoh, docs/design.md, "Topic and service name mapping".
    chatter = f"chatter/std_msgs::msg::dds_::String_/{STRING.type_hash}"
    assert rmw_key(0, "/chatter", STRING) == f"0/{chatter}"
    assert rmw_key(2, "/robot1/chatter", STRING) == f"2/robot1/{chatter}"


def test_rmw_tokens_are_those_of_the_design_document():
    # rmw_zenoh, docs/design.md, "Graph Cache"; their endpoints are number 10.
    chatter = f"%chatter/std_msgs::msg::dds_::String_/{STRING.type_hash}"
    heard = Port("/chatter", STRING, RELIABLE)
    assert rmw_node_token(LISTENER) == (
        "@ros2_lv/2/aac3178e146ba6f1fc6e6a4085e77f21/0/0/NN/%/%/listener"
    )
    assert rmw_endpoint_token(LISTENER, 10, Endpoint.SUBSCRIPTION, heard) == (
        f"@ros2_lv/2/aac3178e146ba6f1fc6e6a4085e77f21/0/10/MS/%/%/listener/{chatter}/::,10:,:,:,,"
    )
    said = Port("/chatter", STRING, "::,7:,:,:,,")
    assert rmw_endpoint_token(TALKER, 10, Endpoint.PUBLISHER, said) == (
        f"@ros2_lv/2/8b20917502ee955ac4476e0266340d5c/0/10/MP/%/%/talker/{chatter}/::,7:,:,:,,"
    )


def test_a_namespace_is_mangled_in_tokens_and_kept_in_keys():
    port = Port("/bot1/cmd_vel", TWIST, RELIABLE)
    token = rmw_endpoint_token(TALKER, 1, Endpoint.PUBLISHER, port)
    assert "/talker/%bot1%cmd_vel/geometry_msgs::msg::dds_::Twist_/" in token


def test_an_rmw_attachment_is_these_33_bytes():
    # rmw_zenoh, docs/design.md, "Publishers": int64, int64, uint8, 16 bytes, little-endian.
    packed = pack_stamp(Stamp(3, 0x0102030405060708, bytes(range(16))))
    assert packed == bytes.fromhex(
        "0300000000000000 0807060504030201 10 000102030405060708090a0b0c0d0e0f"
    )


def test_dds_names():
    assert dds_name(LASER_SCAN) == "sensor_msgs::msg::dds_::LaserScan_"
    assert dds_name(TWIST_STAMPED) == "geometry_msgs::msg::dds_::TwistStamped_"


@pytest.mark.parametrize("topic", ["scan", "/scan", "bot_1/front/scan"])
def test_topics_that_ros_allows_get_a_leading_slash(topic: str):
    assert check_topic("--topic", topic) == "/" + topic.lstrip("/")


@pytest.mark.parametrize("topic", ["", "/", "a//b", "a/", "1scan", "a/*", "~/a", "a b", "a$*", "é"])
def test_other_topics_are_refused(topic: str):
    with pytest.raises(UsageError, match="--topic"):
        check_topic("--topic", topic)


HEARD = [Port("/scan", LASER_SCAN, BEST_EFFORT)]
SPOKEN = [Port("/cmd_vel", TWIST, RELIABLE)]


def test_wires_by_name():
    assert wire_named("ros2dds", 7).key("/scan", LASER_SCAN) == "scan"
    assert wire_named("ros2dds").tokens("ab", HEARD, SPOKEN) == ()
    assert wire_named("rmw", 7).key("/scan", LASER_SCAN).startswith("7/scan/sensor_msgs::msg::")
    node, heard, spoken = wire_named("rmw", 7).tokens("ab", HEARD, SPOKEN)
    assert node == "@ros2_lv/7/ab/0/0/NN/%/%/reflexarc"
    assert "/1/MS/%/%/reflexarc/%scan/" in heard
    assert heard.endswith("/2::,5:,:,:,,")  # best effort hears every publisher
    assert "/2/MP/%/%/reflexarc/%cmd_vel/" in spoken


def test_humble_has_no_hashes_in_keys_and_tokens():
    # rmw_zenoh on Humble: rosidl has no hash there, and the key says so in its place.
    humble = wire_named("rmw", 0, has_hashes=False)
    name = "sensor_msgs::msg::dds_::LaserScan_/TypeHashNotSupported"
    assert humble.key("/scan", LASER_SCAN) == f"0/scan/{name}"
    _, heard, spoken = humble.tokens("ab", HEARD, SPOKEN)
    assert heard == f"@ros2_lv/0/ab/0/1/MS/%/%/reflexarc/%scan/{name}/2::,5:,:,:,,"
    assert "RIHS01" not in spoken


@pytest.mark.parametrize(
    ("node", "expected"),
    [
        ("left_eye", "%/left_eye"),
        ("/left_eye", "%/left_eye"),
        ("bot1/left_eye", "%bot1/left_eye"),
        ("/hall/bot1/left_eye", "%hall%bot1/left_eye"),
    ],
)
def test_every_token_of_a_node_bears_its_name_and_namespace(node: str, expected: str):
    tokens = wire_named("rmw", 3, node=node).tokens("ab", HEARD, SPOKEN)
    assert ["/".join(token.split("/")[7:9]) for token in tokens] == [expected] * 3


@pytest.mark.parametrize("node", ["", "/", "1eye", "a b", "bot1/", "a//b", "é", "a" * 256])
def test_other_names_of_nodes_are_refused(node: str):
    with pytest.raises(UsageError, match="--node"):
        wire_named("rmw", node=node)


@pytest.mark.parametrize(("name", "domain"), [("dds", 0), ("rmw", -1), ("rmw", 233)])
def test_other_wires_are_refused(name: str, domain: int):
    with pytest.raises(UsageError, match="expected"):
        wire_named(name, domain)
