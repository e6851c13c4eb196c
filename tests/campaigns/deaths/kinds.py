"""How a service dies in this campaign, and what became of each death."""

import signal
from dataclasses import dataclass, field

from campaigns.ends.kinds import HANG_NUMPY, HANG_PYTHON


@dataclass(frozen=True)
class Way:
    """One way to die."""

    name: str
    number: int
    """The signal; those that cause a hang in the loop are heard by `campaigns.ends.faulty`."""
    at_start: bool = False
    """Whether it strikes before the runtime has made its first tick."""


WAYS = (
    Way("SIGKILL", signal.SIGKILL),
    Way("SIGSEGV", signal.SIGSEGV),
    Way("SIGABRT", signal.SIGABRT),
    Way("SIGSTOP: hangs as a whole", signal.SIGSTOP),
    Way("hangs in Python", HANG_PYTHON),
    Way("hangs in NumPy, the lock held", HANG_NUMPY),
    Way("SIGKILL while it starts", signal.SIGKILL, at_start=True),
)


@dataclass
class Death:
    """One death, and how the service came back."""

    number: int
    way: str
    after_s: float
    """How long the robot drove before it, or the runtime was starting."""
    again_s: float = 0.0
    """From the blow to the next runtime that the body obeys."""
    ended_s: float = 0.0
    """From the blow to the end of the process: how long a hang went on."""
    started_s: float = 0.0
    """From that end to the next runtime's first tick: the pause of the unit, and the start."""
    status: int | None = None
    cause: str = ""
    """Why the manager ended it; empty: it ended by itself."""
    failures: list[str] = field(default_factory=list)
