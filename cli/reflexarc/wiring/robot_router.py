"""Joining a robot's bus as a client of its router, which may start later than we do."""

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from reflexarc.terminal.output import aside
from reflexarc.wiring.bus_flags import Joining
from reflexarc_runtime.errors import NoRouterError

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Bus

LOOK_AGAIN_S = 0.2


def joined(
    joining: Joining, node: str, stop: Callable[[], bool], who: str, *, client: bool
) -> "Bus | None":
    """A session on the robot's bus, as soon as there is a router to join.

    Args:
        joining: the flags.
        node: what the command is on the bus.
        stop: ends the waiting.
        who: the name of the waiting command, for its notice.
        client: whether to join as a client; a Zenoh configuration of the user's own says so itself.

    Returns:
        The session, or None when asked to stop before there was a router.
    """
    said = False
    while not stop():
        try:
            return joining.bus(node, client=client)
        except NoRouterError as error:
            if not said:
                aside.print(f"{who}: {error}: waiting for it …")
            said = True
        time.sleep(LOOK_AGAIN_S)
    return None
