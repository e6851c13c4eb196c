"""Keys and liveliness tokens of ROS 2 on Zenoh: one pure function for each format.

zenoh-plugin-ros2dds (`ros2_name_to_key_expr`): a topic's key is its full name without the leading
slash.

rmw_zenoh (its docs/design.md, "Topic and service name mapping" and "Graph cache"): a topic's key is
`<domain>/<topic>/<type>/<hash>`; nodes and their endpoints are liveliness tokens under `@ros2_lv`,
in which each `/` within a name becomes `%`. A message carries the 33 bytes that our own bus took
over (`reflexarc_runtime.messages.wire`).
"""

import re
from dataclasses import dataclass, replace
from enum import StrEnum

from reflexarc_runtime.errors import UsageError

MAX_DOMAIN = 232
"""The highest ROS_DOMAIN_ID (docs.ros.org, "The ROS_DOMAIN_ID")."""

_TOPIC = re.compile(r"/?[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*")
"""Names as design.ros2.org/articles/topic_and_service_names.html allows them, once expanded."""

NO_TYPE_HASH = "TypeHashNotSupported"
"""What Humble's rmw_zenoh writes in place of a hash: hashes came with Iron (REP-2016)."""

MAX_NAME_LENGTH = 255
"""Of a node's name (rmw/validate_node_name.h)."""

_TYPE_NAME = re.compile(r"(\w+)/msg/(\w+)")


@dataclass(frozen=True, slots=True)
class RosType:
    """A message type: its name and its version-1 hash (REP-2016, RIHS01)."""

    name: str
    """As `ros2 interface` spells it: `sensor_msgs/msg/LaserScan`."""
    type_hash: str
    """As `ros2 topic info --verbose` prints it on Jazzy. It changes with the definition only."""

    def without_hash(self) -> "RosType":
        """The same as a distribution spells it that has no hashes."""
        return replace(self, type_hash=NO_TYPE_HASH)


LASER_SCAN = RosType(
    "sensor_msgs/msg/LaserScan",
    "RIHS01_64c191398013af96509d518dac71d5164f9382553fce5c1f8cca5be7924bd828",
)
ODOMETRY = RosType(
    "nav_msgs/msg/Odometry",
    "RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0",
)
TWIST = RosType(
    "geometry_msgs/msg/Twist",
    "RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a",
)
TWIST_STAMPED = RosType(
    "geometry_msgs/msg/TwistStamped",
    "RIHS01_5f0fcd4f81d5d06ad9b4c4c63e3ea51b82d6ae4d0558f1d475229b1121db6f64",
)

ODOMETRY = RosType(
    "nav_msgs/msg/Odometry",
    "RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0",
)
TF_MESSAGE = RosType(
    "tf2_msgs/msg/TFMessage",
    "RIHS01_e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
)


class Endpoint(StrEnum):
    """What an endpoint's token says that it is."""

    PUBLISHER = "MP"
    SUBSCRIPTION = "MS"


RELIABLE = "::,10:,:,:,,"
"""Reliable, volatile, the last 10: what ROS 2 calls the default profile."""
BEST_EFFORT = "2::,5:,:,:,,"
"""Best effort, volatile, the last 5: the profile of sensor data. It matches every publisher."""

LATCHED = ":1:,100:,:,:,,"
"""Reliable, transient local, the last 100: tf2's profile of `/tf_static`."""


@dataclass(frozen=True, slots=True)
class RosNode:
    """A node of the ROS graph, without an enclave."""

    domain: int
    session_id: str
    """Of the Zenoh session, in hexadecimal."""
    name: str
    namespace: str = "/"

    def token(self, number: int, kind: str) -> str:
        """The part of a token that says whose it is."""
        space = mangled(self.namespace)
        return f"@ros2_lv/{self.domain}/{self.session_id}/0/{number}/{kind}/%/{space}/{self.name}"


@dataclass(frozen=True, slots=True)
class Port:
    """A topic of a node, which the node hears or speaks on."""

    topic: str
    """Full name, with its leading slash."""
    kind: RosType
    quality: str
    """Of service, as rmw_zenoh's `qos_to_keyexpr` writes it: what is left out is default."""


def check_topic(flag: str, topic: str) -> str:
    """The topic with its leading slash.

    Raises:
        UsageError: ROS 2 does not allow such a name.
    """
    if not _TOPIC.fullmatch(topic):
        raise UsageError(
            f"{flag}: expected a topic name (letters, digits, _, parts divided by /), got {topic!r}"
        )
    return "/" + topic.removeprefix("/")


def check_node(flag: str, name: str) -> tuple[str, str]:
    """The namespace and the name of a node, from its name with or without a namespace.

    Raises:
        UsageError: ROS 2 does not allow such a name.
    """
    namespace, _, last = name.rpartition("/")
    if not _TOPIC.fullmatch(name) or len(last) > MAX_NAME_LENGTH:
        raise UsageError(
            f"{flag}: expected a node's name (letters, digits, _; a namespace before it, divided "
            f"by /), got {name!r}"
        )
    return "/" + namespace.removeprefix("/"), last


def ros2dds_key(topic: str) -> str:
    """Key of a topic under zenoh-plugin-ros2dds."""
    return topic.strip("/")


def rmw_key(domain: int, topic: str, kind: RosType) -> str:
    """Key of a topic under rmw_zenoh."""
    return f"{domain}/{topic.strip('/')}/{dds_name(kind)}/{kind.type_hash}"


def dds_name(kind: RosType) -> str:
    """A type's name as DDS spells it: `sensor_msgs::msg::dds_::LaserScan_`."""
    return _TYPE_NAME.sub(r"\1::msg::dds_::\2_", kind.name)


def mangled(name: str) -> str:
    """A name as a part of a token."""
    return name.replace("/", "%")


def rmw_node_token(node: RosNode) -> str:
    """Liveliness token of a node; its own identifier is 0."""
    return node.token(0, "NN")


def rmw_endpoint_token(node: RosNode, number: int, endpoint: Endpoint, port: Port) -> str:
    """Liveliness token of a publisher or subscription.

    Args:
        node: whose it is.
        number: tells the node's endpoints apart.
        endpoint: which of the two.
        port: what it hears or says.
    """
    kind = f"{dds_name(port.kind)}/{port.kind.type_hash}"
    return f"{node.token(number, endpoint)}/{mangled(port.topic)}/{kind}/{port.quality}"


def rmw_history_key(key: str) -> str:
    """Where the publishers of a topic answer that is transient local: what was said before.

    rmw_zenoh keeps it in the cache of Zenoh's advanced publisher
    (zenoh-ext, `advanced_publisher.rs`: `<key>/@adv/pub/<session>/<entity>/…`).
    """
    return f"{key}/@adv/pub/**?_anyke;_max=100"
