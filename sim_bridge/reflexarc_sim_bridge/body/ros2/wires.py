"""The two ways in which ROS 2 uses Zenoh, behind one interface."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.ros2.ros_types import RosType
from reflexarc_sim_bridge.body.ros2.key_expressions import (
    MAX_DOMAIN,
    Endpoint,
    Port,
    RosNode,
    check_node,
    rmw_endpoint_token,
    rmw_key,
    rmw_node_token,
    ros2dds_key,
)

NODE_NAME = "reflexarc"
WIRES = ("ros2dds", "rmw")


class Wire(Protocol):
    """Keys of topics, and the liveliness tokens that announce a node."""

    @property
    def has_router(self) -> bool:
        """Whether the robot's nodes meet others only through a router, whose client we must be."""
        ...

    def key(self, topic: str, kind: RosType) -> str:
        """Key of a topic."""
        ...

    def tokens(
        self, session_id: str, heard: Sequence[Port], spoken: Sequence[Port]
    ) -> tuple[str, ...]:
        """Liveliness tokens of a node that hears some topics and speaks on others."""
        ...


@dataclass(frozen=True, slots=True)
class Ros2DdsWire:
    """zenoh-plugin-ros2dds: a robot on DDS, and a Zenoh bridge beside it.

    Its keys name no type, so they are the same for every distribution.
    """

    @property
    def has_router(self) -> bool:
        """See `Wire.has_router`: its bridge speaks with peers, too."""
        return False

    def key(self, topic: str, kind: RosType) -> str:
        """See `Wire.key`."""
        return ros2dds_key(topic)

    def tokens(
        self, session_id: str, heard: Sequence[Port], spoken: Sequence[Port]
    ) -> tuple[str, ...]:
        """None: its routes open without tokens, which only its bridges exchange."""
        return ()


@dataclass(frozen=True, slots=True)
class RmwWire:
    """rmw_zenoh: a robot whose middleware is Zenoh.

    Its nodes listen on the loopback of their own machine, and its router passes nothing on between
    two peers (`peers_failover_brokering: false`): a peer on another machine hears a node or not, by
    which Zenoh identifier is greater. A client of the router always does.
    """

    domain: int = 0
    has_hashes: bool = True
    """Whether the keys have type hashes: all distributions do but Humble."""
    node: str = NODE_NAME
    """Name of our node, with its namespace if it has one."""

    def __post_init__(self) -> None:
        if not 0 <= self.domain <= MAX_DOMAIN:
            raise UsageError(f"--domain: expected 0 to {MAX_DOMAIN}, got {self.domain}")
        check_node("--node", self.node)

    @property
    def has_router(self) -> bool:
        """See `Wire.has_router`."""
        return True

    def key(self, topic: str, kind: RosType) -> str:
        """See `Wire.key`."""
        return rmw_key(self.domain, topic, self._spelt(kind))

    def tokens(
        self, session_id: str, heard: Sequence[Port], spoken: Sequence[Port]
    ) -> tuple[str, ...]:
        """See `Wire.tokens`."""
        namespace, name = check_node("--node", self.node)
        node = RosNode(self.domain, session_id, name, namespace)
        ends = [(Endpoint.SUBSCRIPTION, port) for port in heard]
        ends += [(Endpoint.PUBLISHER, port) for port in spoken]
        return (
            rmw_node_token(node),
            *(
                rmw_endpoint_token(node, number, end, replace(port, kind=self._spelt(port.kind)))
                for number, (end, port) in enumerate(ends, 1)
            ),
        )

    def _spelt(self, kind: RosType) -> RosType:
        return kind if self.has_hashes else kind.without_hash()


def wire_named(
    name: str, domain: int = 0, *, has_hashes: bool = True, node: str = NODE_NAME
) -> Wire:
    """The wire for the value of `--wire`.

    Raises:
        UsageError: another name, or a domain or a node's name that ROS 2 does not have.
    """
    if name not in WIRES:
        raise UsageError(f"--wire: expected {' or '.join(WIRES)}, got {name!r}")
    return RmwWire(domain, has_hashes, node) if name == "rmw" else Ros2DdsWire()
