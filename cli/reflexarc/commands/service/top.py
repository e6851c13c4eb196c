"""`reflexarc top`: every robot on the bus, live."""

import math
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import tyro

from reflexarc.terminal.output import aside, console, print_json
from reflexarc.terminal.signals import StopFlag
from reflexarc.wiring.bus_flags import Joining
from reflexarc.wiring.sight.metrics_flags import MetricsFlags
from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from reflexarc.wiring.sight.fleet_watch import FleetWatch
    from reflexarc_runtime.bus import Bus

MAX_PATIENCE_S = 3600.0
_LOOK_S = 0.1
_SHOW_S = 0.5
_SAY_S = 1.0
_WHO = "reflexarc top"


@dataclass(frozen=True)
class TopCommand:
    """Show every robot on the bus: its rate, lateness, verdict, action, policy, lease, recorder.

    It only listens: to what runtimes and bodies say of themselves once a second, and to the leases.
    `q` or Ctrl-C ends it. As many columns are shown as the terminal has room for. With --once it
    waits until each robot must have been heard, shows them, and ends with 0, or with 1 if nobody
    was. Where no terminal is, it is as with --once, unless it serves metrics or prints --json,
    which go on until Ctrl-C.

    Examples:
      reflexarc top
      reflexarc top --once --json
      reflexarc top --json | jq -c '.robots[] | [.robot, .runtimes[0].verdict]'
      reflexarc top --metrics 9464
      reflexarc top --zenoh secure/viewer.json5
    """

    once: bool = False
    """Show the robots one time, and end."""
    json: bool = False
    """Print one JSON object: one time with --once, or else every second."""
    patience: float = 3.0
    """Seconds that --once waits for the first word of anybody."""
    metrics: tyro.conf.OmitArgPrefixes[MetricsFlags] = field(default_factory=MetricsFlags)
    port: int = 7447
    """Port of 127.0.0.1 on which a body listens."""
    zenoh: Path | None = None
    """Zenoh configuration (JSON5) in place of the loopback: other machines, TLS, access."""
    allow_open: bool = False
    """Join although --zenoh lets strangers in: a plain listener, or scouting by multicast."""

    def run(self) -> int:
        """Listen and show until the end."""
        self._check_flags()
        from reflexarc.wiring.sight.fleet_watch import FleetWatch
        from reflexarc_runtime.messages.access import VIEWER

        joining = Joining(port=self.port, zenoh=self.zenoh, allow_open=self.allow_open)
        with StopFlag() as stop, joining.bus_in_time(VIEWER, stop, _WHO) as bus:
            watch = FleetWatch(bus)
            with self.metrics.served(_WHO, watch.view):
                return self._show(watch, bus, stop)

    def _check_flags(self) -> None:
        self.metrics.check()
        if not 0.0 < self.patience <= MAX_PATIENCE_S:
            raise UsageError(f"--patience: expected above 0 to 3600 s, got {self.patience}")
        if self.once and self.metrics.metrics is not None:
            raise UsageError("--once: expected no --metrics beside it, which go on")

    def _show(self, watch: "FleetWatch", bus: "Bus", stop: StopFlag) -> int:
        is_serving = self.metrics.metrics is not None
        if self.once:
            return self._once(watch, bus, stop)
        if self.json:
            return _every(_SAY_S, stop, lambda: _print_json(watch))
        if console.is_terminal:
            return _live(watch, bus, stop)
        if is_serving:
            return _every(_SAY_S, stop, lambda: None)
        return self._once(watch, bus, stop)

    def _once(self, watch: "FleetWatch", bus: "Bus", stop: StopFlag) -> int:
        watch.await_all(self.patience, stop)
        fleet = watch.view()
        if self.json:
            _print_json(watch)
        elif fleet.robots:
            from reflexarc.terminal.fleet_table import fleet_screen

            console.print(fleet_screen(fleet, console.width, None))
        if not fleet.robots:
            aside.print(f"{_WHO}: {_nobody(bus, self.patience)}", soft_wrap=True)
        return 0 if fleet.robots else 1


def _nobody(bus: "Bus", patience_s: float) -> str:
    if not bus.neighbours:
        return f"no robot was heard within {patience_s:g} s: {bus.loneliness}"
    return f"no robot was heard within {patience_s:g} s, of {bus.neighbours} connected"


def _print_json(watch: "FleetWatch") -> None:
    from reflexarc_runtime.fleet.as_json import fleet_as_dict

    print_json(fleet_as_dict(watch.view()))
    sys.stdout.flush()


def _every(period_s: float, stop: Callable[[], bool], do: Callable[[], None]) -> int:
    """Do something again and again, until asked to stop; what was missed is left out."""
    due_s = time.monotonic() + period_s
    while not stop():
        if time.monotonic() >= due_s:
            do()
            due_s += period_s * max(1, math.ceil((time.monotonic() - due_s) / period_s))
        time.sleep(_LOOK_S)
    return 0


def _live(watch: "FleetWatch", bus: "Bus", stop: StopFlag) -> int:
    """The table on the whole terminal, until a key or a signal ends it."""
    from rich.live import Live

    from reflexarc.terminal.fleet_table import fleet_screen
    from reflexarc.terminal.keyboard import Keys

    with Keys() as keys, Live(console=console, screen=True, auto_refresh=False) as live:

        def show() -> None:
            fleet, size = watch.view(), console.size
            head = f"{_WHO}  {time.strftime('%H:%M:%S')}  q ends"
            if not fleet.robots:
                head += f"  {'nobody says a word yet' if bus.neighbours else bus.loneliness}"
            live.update(fleet_screen(fleet, size.width, size.height, head), refresh=True)

        show()
        return _every(_SHOW_S, lambda: stop() or keys.wants_to_quit(), show)
