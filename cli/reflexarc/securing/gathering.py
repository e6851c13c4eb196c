"""Everybody at one door, each in a session of its own."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from reflexarc.securing.variants import Settings, connecting, session

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Bus

NOBODY = "nobody"
"""A certificate of the right authority that names no role."""
ARRIVES_WITHIN_S = 5.0
SETTLES_S = 0.3
"""How long is waited for what shall not come, once all has come that shall."""


@dataclass(frozen=True)
class Gathering:
    """Who is at a door of one's own."""

    robot: str
    host: "Bus"
    """The door's own session."""
    guests: "dict[str, Bus]"
    """Role → session; `NOBODY` among them, where a certificate of no role can be made."""

    @property
    def roles(self) -> list[str]:
        """Those who have a role."""
        return [role for role in self.guests if role != NOBODY]


@contextmanager
def guests_at(
    locator: str, robot: str, settings: dict[str, Settings]
) -> "Iterator[dict[str, Bus]]":
    """Sessions of several roles at a door.

    Raises:
        BusError: one does not come in.
    """
    with ExitStack() as stack:
        yield {
            role: stack.enter_context(session(robot, connecting(own, locator)))
            for role, own in settings.items()
        }
