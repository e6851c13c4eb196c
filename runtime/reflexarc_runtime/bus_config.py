"""How a node joins the bus. Checked here, so that nothing loads Zenoh to check a name."""

import re
from dataclasses import dataclass
from pathlib import Path

from reflexarc_runtime.config.checks import require
from reflexarc_runtime.messages.topics import DEFAULT_ROBOT

DEFAULT_PORT = 7447
LOOPBACK = "127.0.0.1"
MAX_MESSAGE_BYTES = 16 << 20
"""Larger ones Zenoh drops while it puts them together, so that nobody fills the memory of a robot;
a policy file is the largest that anybody needs."""

ROBOT_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,63}")
ROBOT_NAME_IN_WORDS = "letters, digits, _ . - (at most 64)"


@dataclass(frozen=True)
class BusConfig:
    """How a node joins the bus."""

    robot: str = DEFAULT_ROBOT
    """First part of every key."""
    port: int = DEFAULT_PORT
    """Port of the loopback interface on which the body listens."""
    listens: bool = False
    """Whether this node is the one that listens there."""
    zenoh_file: Path | None = None
    """A Zenoh configuration (JSON5) to use in place of all this."""
    client: bool = False
    """Whether this node reaches the others only through the router that listens on that port."""
    waits: bool = False
    """Whether a message waits for a busy network, as in lockstep, where a lost one is never asked
    for again; else it is dropped, as the next one is fresher."""
    allow_open: bool = False
    """Whether the Zenoh configuration may let in whoever reaches it: a plain listener that is not
    the loopback's, or scouting by multicast."""

    def __post_init__(self) -> None:
        is_name = ROBOT_NAME.fullmatch(self.robot) is not None
        require(is_name, "--robot", ROBOT_NAME_IN_WORDS, repr(self.robot))
        require(1 <= self.port <= 65535, "--port", "1 to 65535", self.port)
