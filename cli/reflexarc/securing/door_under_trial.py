"""A door of one's own, at which everybody does everything, with real sessions.

Silence proves something only where somebody else is heard: each right is tried of those who have
it as well, and one that is lacking is said.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from reflexarc.securing.authority import Authority, Validity
from reflexarc.securing.door_row import DoorRow
from reflexarc.securing.gathering import NOBODY, Gathering, guests_at
from reflexarc.securing.hearing import hearing_row
from reflexarc.securing.living import living_row
from reflexarc.securing.questions import answering_row, asking_row
from reflexarc.securing.secured_robot import SecuredRobot
from reflexarc.securing.speaking import speaking_rows
from reflexarc.securing.variants import Settings, listening, session, showing
from reflexarc_runtime.messages.access import common_name


@dataclass(frozen=True)
class DoorUnderTrial:
    """A door with the rights of the folder's, at a free port."""

    secured: SecuredRobot
    door: Settings
    """Its settings."""
    guests: dict[str, Settings]
    """Role → settings."""
    port: int

    def rows(self, authority: Authority | None) -> Iterator[DoorRow]:
        """Let everybody try everything."""
        robot, locator = self.secured.robot, f"tls/127.0.0.1:{self.port}"
        with (
            session(robot, listening(self.door, self.port)) as host,
            guests_at(locator, robot, self._guests(authority)) as guests,
        ):
            all_here = Gathering(robot, host, guests)
            yield from speaking_rows(all_here)
            yield hearing_row(all_here)
            yield asking_row(all_here)
            yield answering_row(all_here)
            yield living_row(all_here)

    def _guests(self, authority: Authority | None) -> dict[str, Settings]:
        """Those of the folder, and one of no role."""
        if authority is None:
            return self.guests
        named = authority.issue(common_name(NOBODY, self.secured.robot), Validity.of_days(1))
        return {**self.guests, NOBODY: showing(next(iter(self.guests.values())), named)}
