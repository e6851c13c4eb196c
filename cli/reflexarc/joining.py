"""What every command on the bus has in common: its flags, and how it joins."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from reflexarc_runtime.bus import BusConfig


@dataclass(frozen=True)
class Joining:
    """Where on the bus."""

    robot: str = "robot0"
    """First part of every key on the bus."""
    port: int = 7447
    """Port of 127.0.0.1 on which the body listens."""
    zenoh: Path | None = None
    """Zenoh configuration (JSON5) in place of the loopback: other machines, TLS, access."""

    def config(self, *, listens: bool = False) -> "BusConfig":
        """How to join; `listens` for the one body."""
        from reflexarc_runtime.bus import BusConfig

        return BusConfig(self.robot, self.port, listens, self.zenoh)
