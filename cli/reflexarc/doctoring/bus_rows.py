"""The robot's bus: whether anybody is there already, and what its configuration lets in."""

import ipaddress
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from reflexarc.doctoring.check_row import CheckRow, Health, unknown, well
from reflexarc.doctoring.machine_files import text_of
from reflexarc_runtime.errors import ReflexarcError, first_line
from reflexarc_runtime.messages.topics import BODY_NODE, RUNTIME_NODE

if TYPE_CHECKING:
    from collections.abc import Callable

    from reflexarc_runtime.bus import Bus

HEARD_S = 2.0
"""How long a runtime that is there may take to be heard of."""
_LISTENING = "0A"
"""State of a socket in /proc/net/tcp."""


def check_bus(
    join: "Callable[[], Bus]", robot: str, port: int, zenoh: Path | None
) -> Iterator[CheckRow]:
    """All that is said of it.

    Args:
        join: opens a session.
        robot: its name.
        port: of the loopback interface.
        zenoh: a configuration in place of that port.
    """
    from importlib.metadata import version

    yield well("Zenoh", version("eclipse-zenoh"))
    if zenoh is None:
        tables = [text_of(f"/proc/net/{name}") for name in ("tcp", "tcp6")]
        if not any(tables):
            yield unknown(f"port {port}", "/proc/net/tcp is not readable")
        else:
            listens = any(port_is_open(table or "", port) for table in tables)
            yield well(f"port {port}", "a body or router listens" if listens else "free")
            if not listens:
                yield well("second brain", "none: nobody listens there")
                return
    else:
        yield _doors(zenoh)
    try:
        with join() as bus:
            brain = _found(lambda: bus.is_alive(RUNTIME_NODE))
            yield judge_brains(robot, brain, bus.is_alive(BODY_NODE))
    except ReflexarcError as error:
        yield unknown("second brain", first_line(error))


def _found(is_there: "Callable[[], bool]") -> bool:
    """Ask again for a while: a session hears of those behind its neighbours one after another."""
    until_s = time.monotonic() + HEARD_S
    while not (found := is_there()) and time.monotonic() < until_s:
        time.sleep(0.1)
    return found


def judge_brains(robot: str, brain: bool, body: bool) -> CheckRow:
    """Whether a runtime of this robot runs already."""
    if not brain:
        return well("second brain", f"none of {robot}, {'a' if body else 'no'} body")
    why = "the body obeys one of them, and holds off the other for as long as it drives"
    remedy = "end one of the two, or name another --robot"
    return CheckRow("second brain", Health.BAD, f"a runtime of {robot} runs", why, remedy)


def port_is_open(table: str, port: int) -> bool:
    """Whether somebody listens on a port that the loopback reaches, by /proc/net/tcp."""
    for line in table.splitlines()[1:]:
        words = line.split()
        if len(words) < 4 or words[3] != _LISTENING:
            continue
        address, _, number = words[1].rpartition(":")
        if int(number, 16) == port and _reaches_loopback(address):
            return True
    return False


def _reaches_loopback(address: str) -> bool:
    """An address as the kernel writes it: words of four bytes in the machine's order."""
    if len(address) != 8:
        return True  # version 6: ours listen on any, or on ::1
    ip = ipaddress.IPv4Address(int.from_bytes(bytes.fromhex(address), "little"))
    return ip.is_loopback or ip.is_unspecified


def _doors(zenoh: Path) -> CheckRow:
    from reflexarc_runtime.bus import settings_of_file
    from reflexarc_runtime.doors.open_doors import open_doors

    try:
        doors = open_doors(settings_of_file(zenoh))
    except ReflexarcError as error:
        return CheckRow("Zenoh's doors", Health.BAD, first_line(error), "the loop cannot join")
    if not doors:
        return well("Zenoh's doors", "shut to strangers")
    why, remedy = "whoever reaches it can drive the robot", "reflexarc secure init"
    return CheckRow("Zenoh's doors", Health.BAD, "; ".join(doors), why, remedy)
