"""Outlets: where a loop, and whoever speaks in its place, hands over what shall go on the bus."""

from dataclasses import dataclass, field
from typing import Protocol


class Outlet(Protocol):
    """Publishes the messages of one topic."""

    def put(self, payload: bytes, time_ns: int) -> None:
        """Send one message; never blocks, never raises."""
        ...


class NoOutlet:
    """Says nothing."""

    def put(self, payload: bytes, time_ns: int) -> None:
        """See `Outlet.put`."""


@dataclass(frozen=True)
class Outlets:
    """The topics on which a runtime publishes."""

    command: Outlet
    tick: Outlet
    status: Outlet
    release: Outlet = field(default_factory=NoOutlet)
    """In lockstep there is none: no lease expires, and the next runtime has the same name."""
