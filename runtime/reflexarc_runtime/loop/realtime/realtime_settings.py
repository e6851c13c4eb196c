"""What a loop asks of the kernel, so that it wakes on time."""

from dataclasses import dataclass

from reflexarc_runtime.config.checks import require

MOST_PRIORITY = 98
"""Of the loop: its watchdog has one more, and the kernel's highest is 99."""
USUAL_PRIORITY = 50
"""Where none is named: above all ordinary work, and equal to the kernel's threaded interrupts."""


@dataclass(frozen=True)
class RealtimeSettings:
    """What is asked; by default only what needs no right and disturbs nobody."""

    priority: int = 0
    """1 to 98 for SCHED_FIFO; 0: ordinary scheduling."""
    processors: tuple[int, ...] = ()
    """Those that the loop's thread may use; empty: all that it has."""
    whole_machine: bool = False
    """Whether memory is locked, and processors are kept out of deep sleep, as well."""
    strict: bool = False
    """Whether a loop that does not get what it needs shall not begin."""

    @property
    def highest_priority(self) -> int:
        """Of all threads: the watchdog's; 0 where none is asked for."""
        return self.priority + 1 if self.priority else 0

    def __post_init__(self) -> None:
        fits = "0 to 98 (the watchdog's is one more)"
        require(0 <= self.priority <= MOST_PRIORITY, "--fifo", fits, self.priority)
        lowest = min(self.processors, default=0)
        require(lowest >= 0, "--cpu", "numbers of processors, from 0 on", lowest)
