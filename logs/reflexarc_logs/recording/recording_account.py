"""What is amiss with a recording: written by its thread, read by the loop's status."""

from dataclasses import dataclass, field

from reflexarc_logs.recording.backlog import Backlog
from reflexarc_logs.recording.budget import Budgets


@dataclass
class RecordingAccount:
    """What a recording has to say for itself."""

    backlog: Backlog
    budgets: Budgets
    failure: str = ""
    """Why nothing is recorded just now."""
    failures: list[str] = field(default_factory=list)
    trouble: str = ""
    """What keeps the current part from getting its name."""
    again_in: str = ""
    """The part in which it went on after the last failure."""
    lost: int = 0
    """Records lost since it failed."""

    def note_failure(self, reason: str) -> None:
        """Say that nothing is recorded any more."""
        self.failures.append(reason)
        self.failure = reason

    def goes_on(self, part: str) -> None:
        """Say that it is recorded again."""
        self.again_in = part
        self.failure, self.trouble, self.lost = "", "", 0

    def left_out(self) -> dict[str, int]:
        """How much is missing so far, by kind."""
        missing = self.backlog.dropped + self.budgets.missing
        return {"dropped": missing, "left_out": self.budgets.beside}
