"""Knocking at a TLS door as those who shall not come in, and as one who shall."""

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta

from reflexarc.securing.authority import Authority, Identity, Validity
from reflexarc.securing.door_row import DoorRow, DoorState
from reflexarc.securing.secured_robot import SecuredRobot
from reflexarc.securing.variants import (
    Settings,
    connecting,
    listening,
    plainly,
    session,
    showing,
)
from reflexarc_runtime.errors import BusError
from reflexarc_runtime.messages.access import common_name
from reflexarc_runtime.words.shown import plain

ELSEWHERE = "elsewhere.invalid"
"""A name that no host has (RFC 6761)."""
_ZENOH = "Unable to connect"
"""What Zenoh says of every reason; only of a certificate that is shown is more known."""
_DAY = timedelta(days=1)


@dataclass(frozen=True)
class Knocker:
    """One guest whose configuration is varied, at one door.

    Args:
        secured: the robot.
        guest: the settings of one who shall come in.
        role: its role.
        locator: the door.
    """

    secured: SecuredRobot
    guest: Settings
    role: str
    locator: str

    def welcome(self) -> DoorRow:
        """Whether the one who shall come in does; if not, why."""
        door = f"{self.role} at {self.locator}"
        refusal = self._refusal(connecting(self.guest, self.locator))
        if refusal is None:
            return DoorRow(door, DoorState.SHUT, "opens to this certificate")
        return DoorRow(door, DoorState.BROKEN, refusal)

    def strangers(self) -> Iterator[DoorRow]:
        """Those who need no authority to be made."""
        yield self._row("plain TCP", plainly(self.locator))
        bare = showing(self.guest, None)
        yield self._row("a stranger without a certificate", connecting(bare, self.locator))
        forger = Authority.made(f"reflexarc authority of {self.secured.robot}"[:64], _valid(-1, 1))
        forged = forger.issue(common_name(self.role, self.secured.robot), _valid(-1, 1))
        yield self._row("a forged certificate of the same names", self._as(forged))

    def late_and_early(self, authority: Authority) -> Iterator[DoorRow]:
        """Certificates of the right authority at the wrong time."""
        name = common_name(self.role, self.secured.robot)
        expired = authority.issue(name, _valid(-2, -1))
        yield self._row("an expired certificate", self._as(expired))
        early = authority.issue(name, _valid(1, 2))
        yield self._row("a certificate of a time to come", self._as(early))

    def false_doors(self, authority: Authority, door: Settings, port: int) -> Iterator[DoorRow]:
        """Doors that pass for this one, at which the guest must not come in.

        Args:
            authority: the right one.
            door: the settings of the true door.
            port: a free one of the loopback.
        """
        name = common_name(self.secured.door, self.secured.robot)
        misnamed = authority.issue(name, _valid(-1, 1), (ELSEWHERE,))
        yield self._false_door("a door of another host's name", door, misnamed, port)
        other = authority.issue(common_name(self.role, self.secured.robot), _valid(-1, 1))
        yield self._false_door(f"a {self.role} that passes for the door", door, other, port)

    def _false_door(self, words: str, door: Settings, own: Identity, port: int) -> DoorRow:
        settings = listening(showing(door, own), port)
        tls = settings["transport"]["link"]["tls"]
        for part in ("certificate", "private_key"):
            tls[f"listen_{part}_base64"] = tls[f"connect_{part}_base64"]
        with session(self.secured.robot, settings):
            return self._row(words, connecting(self.guest, f"tls/127.0.0.1:{port}"))

    def _as(self, own: Identity) -> Settings:
        return connecting(showing(self.guest, own), self.locator)

    def _row(self, door: str, settings: Settings) -> DoorRow:
        refusal = self._refusal(settings)
        if refusal is None:
            return DoorRow(door, DoorState.OPEN, "came in")
        return DoorRow(door, DoorState.SHUT, refusal)

    def _refusal(self, settings: Settings) -> str | None:
        """Why nobody comes in so; None: somebody does."""
        try:
            with session(self.secured.robot, settings):
                return None
        except BusError as error:
            return _without_file(str(error))


def _without_file(reason: str) -> str:
    """The file is one of ours that is gone by now: what comes after its name and the door's."""
    _, _, rest = reason.partition(".json5: ")
    if rest.startswith(_ZENOH):
        return "no session comes about"
    locator, colon, words = rest.partition(": ")
    return plain(words if colon and "/" in locator.partition(" ")[0] else rest or reason)


def _valid(first_day: int, last_day: int) -> Validity:
    now = datetime.now(UTC)
    return Validity(now + first_day * _DAY, now + last_day * _DAY)
