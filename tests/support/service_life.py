"""One life of a service, from a process's start to its end."""

from dataclasses import dataclass


@dataclass
class Life:
    """One process of a service. Times are monotonic, in seconds."""

    pid: int
    began_s: float
    ready_s: float | None = None
    cause: str = ""
    """Why its manager ended it; empty: it ended by itself."""
    ended_s: float | None = None
    status: int | None = None
    """Negative: the signal that ended it."""
