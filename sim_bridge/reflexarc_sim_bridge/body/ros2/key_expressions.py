"""Keys and liveliness tokens of ROS 2 on Zenoh: one pure function for each format.

zenoh-plugin-ros2dds (`ros2_name_to_key_expr`): a topic's key is its full name without the leading
slash.

rmw_zenoh (its docs/design.md, "Topic and service name mapping" and "Graph cache"): a topic's key is
`<domain>/<topic>/<type>/<hash>`; nodes and their endpoints are liveliness tokens under `@ros2_lv`,
in which each `/` within a name becomes `%`. A message carries the 33 bytes that our own bus took
over (`reflexarc_runtime.messages.wire`).
"""

import re
from dataclasses import dataclass
from enum import StrEnum

from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.ros2.ros_types import RosType

MAX_DOMAIN = 232
"""The highest ROS_DOMAIN_ID (docs.ros.org, "The ROS_DOMAIN_ID")."""

_TOPIC = re.compile(r"/?[A-Za-z_][A-Za-z0-9_]*(/[A-Za-z_][A-Za-z0-9_]*)*")
"""Names as design.ros2.org/articles/topic_and_service_names.html allows them, once expanded."""

MAX_NAME_LENGTH = 255
"""Of a node's name (rmw/validate_node_name.h)."""

_TYPE_NAME = re.compile(r"(\w+)/msg/(\w+)")


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
