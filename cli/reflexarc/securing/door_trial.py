"""All doors of a folder, tried one after the other; the list of `reflexarc secure check`."""

import socket
from collections.abc import Iterator

from reflexarc.securing.authority import Authority
from reflexarc.securing.door_in_use import rows_in_use
from reflexarc.securing.door_row import DoorRow, DoorState
from reflexarc.securing.door_under_trial import DoorUnderTrial
from reflexarc.securing.folder_doors import folder_rows
from reflexarc.securing.knocking import Knocker
from reflexarc.securing.secured_robot import SecuredRobot
from reflexarc.securing.security_folder import SecurityFolder
from reflexarc.securing.variants import listening, session, settings_of
from reflexarc_runtime.errors import BusError, UsageError


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
    settings = {role: settings_of(folder, role) for role in guests}
    try:
        yield from rows_in_use(secured.robot, settings, locator)
    except BusError as error:
        yield DoorRow("the roles at the door in use", DoorState.BROKEN, str(error))


def _free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port: int = server.getsockname()[1]
        return port
