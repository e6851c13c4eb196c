"""The flags by which a loop asks to be woken on time, and what they ask for."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from reflexarc_runtime.loop.realtime import RealtimeSettings

MOST_PROCESSORS = 4096


@dataclass(frozen=True)
class RealtimeFlags:
    """What a run asks of the kernel, so that it wakes on time."""

    realtime: Literal["off", "warn", "strict"] = "off"
    """Ask for SCHED_FIFO (--fifo, else 50), locked memory and processors that do not sleep deeply.
    `warn`: what is refused is said; `strict`: a run that does not get it does not begin. `off`:
    only for what --fifo and --cpu name."""
    fifo: int = 0
    """SCHED_FIFO priority of the loop, 1 to 98 (its watchdog has one more); 0: ordinary scheduling,
    with --realtime 50."""
    cpu: tuple[int, ...] = ()
    """Processors that the loop's thread may use; all by default."""

    def check(self, *, lockstep: bool) -> None:
        """Check the flags; with `strict`, ask for it all, and give it back.

        Raises:
            UsageError: they cannot be, or what is needed is refused.
        """
        from reflexarc_runtime.loop.realtime import Realtime
        from reflexarc_runtime.loop.realtime.grant import require_all

        settings = self.settings
        if max(self.cpu, default=0) >= MOST_PROCESSORS:
            raise UsageError(f"--cpu: expected below {MOST_PROCESSORS}, got {max(self.cpu)}")
        if self.realtime != "off" and lockstep:
            raise UsageError(
                "--realtime: not with --lockstep, where no time passes; leave one of them out"
            )
        if settings.strict:
            with Realtime(settings) as tried:
                require_all(tried.grants)

    @property
    def unpressed(self) -> "RealtimeFlags":
        """The same, for who checks them with other rights than the run will have."""
        return replace(self, realtime="warn") if self.realtime == "strict" else self

    @property
    def settings(self) -> "RealtimeSettings":
        """What is asked for.

        Raises:
            UsageError: no such priority or processor.
        """
        from reflexarc_runtime.loop.realtime import RealtimeSettings
        from reflexarc_runtime.loop.realtime.realtime_settings import USUAL_PRIORITY

        is_asked = self.realtime != "off"
        priority = self.fifo or (USUAL_PRIORITY if is_asked else 0)
        return RealtimeSettings(priority, self.cpu, is_asked, self.realtime == "strict")
