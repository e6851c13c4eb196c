"""The two ways in which ROS 2 uses Zenoh, behind one interface."""

from dataclasses import dataclass
from typing import Protocol

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.body.ros2.key_expressions import (
    BEST_EFFORT,
    MAX_DOMAIN,
    RELIABLE,
    Endpoint,
    RosNode,
    RosType,
    rmw_endpoint_token,
    rmw_key,
    rmw_node_token,
    ros2dds_key,
)

NODE_NAME = "reflexarc"
WIRES = ("ros2dds", "rmw")


class Wire(Protocol):
    """Keys of topics, and the liveliness tokens that announce a node."""

    def key(self, topic: str, kind: RosType) -> str:
        """Key of a topic."""
        ...

    def tokens(
        self, session_id: str, heard: tuple[str, RosType], spoken: tuple[str, RosType]
    ) -> tuple[str, ...]:
        """Liveliness tokens of a node that hears one topic and speaks on another."""
        ...


@dataclass(frozen=True, slots=True)
class Ros2DdsWire:
    """zenoh-plugin-ros2dds: a robot on DDS, and a Zenoh bridge beside it."""

    def key(self, topic: str, kind: RosType) -> str:
        """See `Wire.key`."""
        return ros2dds_key(topic)

    def tokens(
        self, session_id: str, heard: tuple[str, RosType], spoken: tuple[str, RosType]
    ) -> tuple[str, ...]:
        """None: its routes open without tokens, which only its bridges exchange."""
        return ()


@dataclass(frozen=True, slots=True)
class RmwWire:
    """rmw_zenoh: a robot whose middleware is Zenoh."""

    domain: int = 0

    def __post_init__(self) -> None:
        if not 0 <= self.domain <= MAX_DOMAIN:
            raise UsageError(f"--domain: expected 0 to {MAX_DOMAIN}, got {self.domain}")

    def key(self, topic: str, kind: RosType) -> str:
        """See `Wire.key`."""
        return rmw_key(self.domain, topic, kind)

    def tokens(
        self, session_id: str, heard: tuple[str, RosType], spoken: tuple[str, RosType]
    ) -> tuple[str, ...]:
        """See `Wire.tokens`."""
        node = RosNode(self.domain, session_id, NODE_NAME)
        return (
            rmw_node_token(node),
            rmw_endpoint_token(node, 1, Endpoint.SUBSCRIPTION, *heard, BEST_EFFORT),
            rmw_endpoint_token(node, 2, Endpoint.PUBLISHER, *spoken, RELIABLE),
        )


def wire_named(name: str, domain: int = 0) -> Wire:
    """The wire for the value of `--wire`.

    Raises:
        UsageError: another name, or a domain that ROS 2 does not have.
    """
    if name not in WIRES:
        raise UsageError(f"--wire: expected {' or '.join(WIRES)}, got {name!r}")
    return RmwWire(domain) if name == "rmw" else Ros2DdsWire()
