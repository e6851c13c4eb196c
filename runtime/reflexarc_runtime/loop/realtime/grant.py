"""One thing that was asked of the kernel, and what came of it."""

from collections.abc import Iterable
from dataclasses import dataclass

from reflexarc_runtime.errors import UsageError


@dataclass(frozen=True)
class Grant:
    """As asked and as obtained."""

    asked: str
    obtained: str
    """Empty: nothing."""
    refusal: str = ""
    """Why not all that was asked."""
    remedy: str = ""
    """What to do about that."""
    is_needed: bool = True
    """Whether a strict loop does not begin without it."""

    @property
    def words(self) -> str:
        """Both in one phrase."""
        if not self.refusal:
            return self.obtained
        got = f", got {self.obtained}" if self.obtained else ""
        return f"{self.asked} refused{got} ({self.refusal})"


def in_words(grants: Iterable[Grant]) -> str:
    """All of them on one line."""
    return "; ".join(grant.words for grant in grants)


def require_all(grants: Iterable[Grant]) -> None:
    """Refuse to go on without what is needed.

    Raises:
        UsageError: some of it was refused; the line says what to do.
    """
    lacking = [grant for grant in grants if grant.refusal and grant.is_needed]
    if lacking:
        words = "; ".join(f"{grant.words}: {grant.remedy}" for grant in lacking)
        raise UsageError(f"--realtime strict: {words}; or --realtime warn, to go on without")
