"""What `reflexarc run` waits for: a sensor's messages; in lockstep, a body that listens."""

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from reflexarc.terminal.output import aside
from reflexarc.wiring.waiting import Arrival, Waiting, Wish
from reflexarc_runtime.messages.topics import COMMAND

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Bus, Publisher

LISTENER_POLL_S = 0.01


def awaiting_input(bus: "Bus", sensor: str, key: str, came: Arrival) -> Waiting:
    """What explains why no input comes, and what to do where another sensor is heard."""
    other = "scan" if sensor == "retina" else "retina"
    advice = {
        f"{bus.robot}/{other}": f"--input {other}",
        f"/{sensor}": "another robot, --robot {first}?",
    }
    return Waiting(bus, Wish("reflexarc run", f"{sensor}s", key, advice=advice), came)


def wait_for_body(bus: "Bus", command: "Publisher", stop: Callable[[], bool]) -> None:
    """Wait for a body: in lockstep, a command without a listener would never be answered."""
    aside.print("reflexarc run: waiting for a body in lockstep …")
    # Whoever overhears commands would be taken for the body that listens.
    around = "*/retina", "*/scan", "*/lease", "*/status"
    wish = Wish("reflexarc run", "a body that listens", COMMAND.key(bus.robot), around)
    with Waiting(bus, wish, lambda: command.has_listener):
        while not command.has_listener and not stop():
            time.sleep(LISTENER_POLL_S)
