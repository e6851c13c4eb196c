"""Outlets: where a loop, and whoever speaks in its place, hands over what shall go on the bus."""

from dataclasses import dataclass
from typing import Protocol


class Outlet(Protocol):
    """Publishes the messages of one topic."""

    def put(self, payload: bytes, time_ns: int) -> None:
        """Send one message; never blocks, never raises."""
        ...


@dataclass(frozen=True)
class Outlets:
    """The topics on which a runtime publishes."""

    command: Outlet
    tick: Outlet
    status: Outlet
