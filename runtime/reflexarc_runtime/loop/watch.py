"""What a loop tells whoever watches it: when a tick begins, when it ends, what it wants to send."""

from typing import Protocol

from reflexarc_runtime.loop.outlets import Outlet


class Watch(Protocol):
    """Watches one loop, which calls these from its own thread at every tick."""

    @property
    def state(self) -> str:
        """`off`, or `on` and within what time; for the status."""
        ...

    def begin(self, now_ns: int) -> None:
        """A tick begins."""
        ...

    def rest(self, now_ns: int) -> None:
        """The tick has ended; the loop waits for the next one."""
        ...

    def let_pass(self, outlet: Outlet, command: bytes, time_ns: int, is_safe: bool) -> bool:
        """Send a command, unless somebody spoke in this loop's place; whether it was sent."""
        ...


class NoWatch:
    """Watches nothing: for lockstep, where no time passes, and for whoever wants none."""

    state = "off"

    def begin(self, now_ns: int) -> None:
        """See `Watch.begin`."""

    def rest(self, now_ns: int) -> None:
        """See `Watch.rest`."""

    def let_pass(self, outlet: Outlet, command: bytes, time_ns: int, is_safe: bool) -> bool:
        """See `Watch.let_pass`."""
        outlet.put(command, time_ns)
        return True
