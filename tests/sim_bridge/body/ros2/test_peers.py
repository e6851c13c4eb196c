"""Keys, hashes, qualities and CDR against what other people's libraries make of the same."""

import pytest

from reflexarc_runtime.ros2.ros_types import (
    LASER_SCAN,
    ODOMETRY,
    TF_MESSAGE,
    TWIST,
    TWIST_STAMPED,
    RosType,
)
from reflexarc_sim_bridge.body.gate.limits import Motion
from reflexarc_sim_bridge.body.ros2.key_expressions import (
    BEST_EFFORT,
    LATCHED,
    RELIABLE,
    Endpoint,
    Port,
    RosNode,
    rmw_endpoint_token,
    rmw_key,
    rmw_node_token,
)
from reflexarc_sim_bridge.body.ros2.messages import encode_twist
from support.ros2_definitions import DEFINITIONS

KINDS = (LASER_SCAN, TWIST, TWIST_STAMPED, ODOMETRY, TF_MESSAGE)
NODE = RosNode(3, "ab12", "left_eye", "/hall/bot1")


@pytest.mark.parametrize("kind", KINDS)
def test_the_sdk_computes_the_same_hash_from_the_definitions(kind: RosType):
    utils = pytest.importorskip("zenoh_ros2_sdk.utils")
    others = {name: text for name, text in DEFINITIONS.items() if name != kind.name}
    text = DEFINITIONS[kind.name]
    found = utils.get_type_hash(kind.name, msg_definition=text, dependencies=others)
    assert found == kind.type_hash


def test_the_sdk_writes_the_same_tokens_and_keys():
    entity = pytest.importorskip("zenoh_ros2_sdk.entity")
    keyexpr = pytest.importorskip("zenoh_ros2_sdk.keyexpr")
    node = entity.NodeEntity(3, "ab12", 0, "left_eye", "/hall/bot1")
    assert keyexpr.node_liveliness_keyexpr(node) == rmw_node_token(NODE)
    end = entity.EndpointEntity(
        node=node,
        entity_id=2,
        kind=entity.EntityKind.PUBLISHER,
        name="/hall/cmd_vel",
        dds_type_name="geometry_msgs::msg::dds_::Twist_",
        type_hash=TWIST.type_hash,
        qos=RELIABLE,
        gid=bytes(16),
    )
    port = Port("/hall/cmd_vel", TWIST, RELIABLE)
    ours = rmw_endpoint_token(NODE, 2, Endpoint.PUBLISHER, port)
    assert keyexpr.endpoint_liveliness_keyexpr(end) == ours


def test_the_sdk_spells_the_same_qualities_of_service():
    qos = pytest.importorskip("zenoh_ros2_sdk.qos")
    sensor = qos.QosProfile(reliability=qos.QosReliability.BEST_EFFORT, history_depth=5)
    latched = qos.QosProfile(durability=qos.QosDurability.TRANSIENT_LOCAL, history_depth=100)
    assert qos.DEFAULT_QOS_PROFILE.encode() == RELIABLE
    assert sensor.encode() == BEST_EFFORT
    assert latched.encode() == LATCHED


@pytest.mark.parametrize("kind", KINDS)
def test_pamoja_makes_the_same_keys(kind: RosType):
    ros2 = pytest.importorskip("pamoja.ros2")
    theirs = ros2.entity_key(7, "/bot1/front", kind.name, kind.type_hash)
    assert rmw_key(7, "/bot1/front", kind) == theirs


def test_pamoja_reads_and_writes_the_same_twists():
    ros2 = pytest.importorskip("pamoja.ros2")
    ours = encode_twist(Motion(1.25, 0.5, -0.75))
    assert ours == ros2.twist_to_cdr((1.25, 0.5, 0.0), (0.0, 0.0, -0.75))
    assert ros2.twist_from_cdr(ours) == ((1.25, 0.5, 0.0), (0.0, 0.0, -0.75))
