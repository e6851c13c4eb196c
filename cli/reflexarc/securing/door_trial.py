"""All doors of a folder, tried one after the other; the list of `reflexarc secure check`."""

import socket
import time
from collections.abc import Iterator

from reflexarc.securing.authority import Authority
from reflexarc.securing.door_row import DoorRow, DoorState
from reflexarc.securing.folder_doors import folder_rows
from reflexarc.securing.knocking import Knocker
from reflexarc.securing.secured_robot import SecuredRobot
from reflexarc.securing.security_folder import SecurityFolder
from reflexarc.securing.speaking import SETTLES_S, DoorUnderTrial
from reflexarc.securing.variants import connecting, listening, session, settings_of
from reflexarc_runtime.errors import BusError, UsageError
from reflexarc_runtime.messages.access import said_by
from reflexarc_runtime.messages.topics import COMMAND, RECORDER_NODE

_GIBBERISH = b"\xff"
"""No protobuf: whoever hears it refuses it, so that a robot in use is not moved by the trial."""


def try_doors(folder: SecurityFolder, locator: str = "") -> Iterator[DoorRow]:
    """Try every door.

    Args:
        folder: of `secure init`, or the copy of a part of it.
        locator: a door in use, tls/host:port, to be tried as well; empty: none.
    """
    yield from folder_rows(folder)
    secured = folder.secured()
    authority = folder.authority() if folder.has_authority else None
    guests = [role for role in secured.guests if folder.file(role).exists()]
    if not guests:
        raise UsageError(f"{folder.path}: expected the configuration of a role, found none")
    if folder.file(secured.door).exists():
        yield from _own_door(folder, secured, guests, authority)
    else:
        words = f"{secured.door}.json5 is not here: check where it is, or with --connect"
        yield DoorRow("a door of one's own", DoorState.UNTRIED, words)
    if locator:
        yield from _door_in_use(folder, secured, guests, authority, locator)


def _own_door(
    folder: SecurityFolder, secured: SecuredRobot, guests: list[str], authority: Authority | None
) -> Iterator[DoorRow]:
    """A door with the settings of the folder's, opened here for the trial."""
    door = settings_of(folder, secured.door)
    settings = {role: settings_of(folder, role) for role in guests}
    port = _free_port()
    guest = Knocker(secured, settings[guests[0]], guests[0], f"tls/127.0.0.1:{port}")
    try:
        with session(secured.robot, listening(door, port)):
            yield guest.welcome()
            yield from _strangers(guest, authority)
        if authority is not None:
            yield from guest.false_doors(authority, door, _free_port())
        yield from DoorUnderTrial(secured, door, settings, _free_port()).rows(authority)
    except BusError as error:
        yield DoorRow("a door of one's own", DoorState.BROKEN, str(error))


def _strangers(guest: Knocker, authority: Authority | None) -> Iterator[DoorRow]:
    yield from guest.strangers()
    if authority is None:
        words = "ca.key is not here: expired certificates and false doors are tried where it is"
        yield DoorRow("the wrong time", DoorState.UNTRIED, words)
    else:
        yield from guest.late_and_early(authority)


def _door_in_use(
    folder: SecurityFolder,
    secured: SecuredRobot,
    guests: list[str],
    authority: Authority | None,
    locator: str,
) -> Iterator[DoorRow]:
    """The door that a robot keeps now."""
    guest = Knocker(secured, settings_of(folder, guests[0]), guests[0], locator)
    welcome = guest.welcome()
    yield welcome
    if welcome.state is DoorState.BROKEN:
        return  # nothing is proved by others who do not come in either
    yield from _strangers(guest, authority)
    yield from _wrong_roles(folder, secured, guests, locator)


def _wrong_roles(
    folder: SecurityFolder, secured: SecuredRobot, guests: list[str], locator: str
) -> Iterator[DoorRow]:
    """Commands of those who may not command, which a recorder would hear."""
    wrong = [role for role in guests if COMMAND not in said_by(role)]
    if RECORDER_NODE not in guests:
        yield DoorRow(
            "wrong roles", DoorState.UNTRIED, "recorder.json5, which listens, is not here"
        )
        return
    settings = {role: connecting(settings_of(folder, role), locator) for role in wrong}
    with session(secured.robot, settings[RECORDER_NODE]) as listener:
        heard: list[bytes] = []
        listener.subscribe([COMMAND], lambda message: heard.append(message.payload))
        for role in wrong:
            with session(secured.robot, settings[role]) as bus:
                publisher = bus.publisher(COMMAND)
                time.sleep(SETTLES_S)
                publisher.put(_GIBBERISH, 0)
                time.sleep(SETTLES_S)
            state = DoorState.OPEN if _GIBBERISH in heard else DoorState.SHUT
            words = "was heard" if state is DoorState.OPEN else "was not heard by a recorder"
            yield DoorRow(f"{role} that commands", state, words)
            heard.clear()


def _free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port: int = server.getsockname()[1]
        return port
