"""`reflexarc view`: a log, or a running robot, in Rerun's viewer."""

import contextlib
import queue
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from reflexarc.terminal.output import aside, plain
from reflexarc.terminal.signals import StopFlag
from reflexarc.wiring.bus_flags import Joining
from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from reflexarc_logs.reading.reader import Log
    from reflexarc_logs.viewing.rerun_canvas import RerunCanvas
    from reflexarc_runtime.messages.wire import Message

    Connect = Callable[["RerunCanvas"], None]

POLL_S = 0.05
MOST_WAITING = 10_000
"""Messages that a viewer may be behind; a robot never waits for who watches it."""


@dataclass(frozen=True)
class ViewCommand:
    """Show a log or a running robot in Rerun: world, path, scan, retina, Q-values, verdicts.

    By default in Rerun's own window; --web serves a page on this machine until Ctrl-C; -o writes a
    file that `rerun` opens. With --live nothing is sent to the robot, and nothing is recorded.

    Examples:
      reflexarc view runs/drive.mcap
      reflexarc view runs/drive.mcap --web
      reflexarc view runs/drive.mcap -o runs/drive.rrd
      reflexarc view --live --robot rover1
    """

    log: tyro.conf.Positional[Path | None] = None
    """A log (MCAP)."""
    live: bool = False
    """Show what is on the bus now, until Ctrl-C."""
    web: bool = False
    """Serve a page for a browser on this machine, until Ctrl-C."""
    web_port: int = 9090
    """Port of that page."""
    data_port: int = 9876
    """Port on which the viewer takes its data; it listens on this machine only."""
    out: Annotated[Path | None, tyro.conf.arg(aliases=["-o"])] = None
    """Write a file (.rrd) in place of showing it."""
    joining: Joining = field(default_factory=Joining)

    def run(self) -> int:
        """Show it."""
        if (self.log is None) != self.live:
            raise UsageError("expected a log, or --live and no log")
        if self.out is not None and self.web:
            raise UsageError("expected --web or -o, got both")
        if self.out is not None and self.out.exists():
            raise UsageError(f"{self.out}: exists already; choose another name or remove it")
        from reflexarc_logs.reading.reader import read_log
        from reflexarc_logs.viewing import rerun_canvas  # noqa: F401  # missing? say so, open nothing

        log = None if self.log is None else read_log(self.log, allow_truncated=True)
        with StopFlag() as stop, self._viewer() as connect:
            if log is None:
                self._view_robot(stop, connect)
                return 0
            self._view_log(log, connect)
            while self.web and not stop():
                time.sleep(POLL_S)
        return 0

    @contextlib.contextmanager
    def _viewer(self) -> "Iterator[Connect]":
        """A viewer, and what connects a canvas to it."""
        from reflexarc_logs.viewing import rerun_viewer

        source, out = rerun_viewer.source_of(self.data_port), self.out
        if out is not None:
            yield lambda canvas: canvas.to_file(out)
        elif not self.web:
            rerun_viewer.open_window(self.data_port)
            yield lambda canvas: canvas.to_viewer(source)
        else:
            page = rerun_viewer.serve_page(self.data_port, self.web_port)
            address = rerun_viewer.page_of(self.data_port, self.web_port)
            aside.print(f"reflexarc view: {address} (Ctrl-C ends it)", soft_wrap=True)
            try:
                yield lambda canvas: canvas.to_viewer(source)
            finally:
                rerun_viewer.end(page)

    def _view_log(self, log: "Log", connect: "Connect") -> None:
        from reflexarc_logs.viewing.log_view import action_names, view_log
        from reflexarc_logs.viewing.rerun_canvas import RerunCanvas

        canvas = RerunCanvas(log.path.name, log.run.run_id, action_names(log.policy))
        connect(canvas)
        shown = view_log(log, canvas)
        canvas.finish()
        aside.print(f"reflexarc view: {plain(str(log.path))}: {shown} messages")

    def _view_robot(self, stop: StopFlag, connect: "Connect") -> None:
        from reflexarc_logs.viewing.drawer import Drawer
        from reflexarc_logs.viewing.log_view import action_names, show
        from reflexarc_logs.viewing.rerun_canvas import RerunCanvas
        from reflexarc_runtime.loop.clock import wall_offset_ns
        from reflexarc_runtime.messages.topics import ON_THE_BUS

        came: queue.Queue[Message] = queue.Queue(MOST_WAITING)
        drawer, offset_ns = Drawer(), wall_offset_ns()
        with self.joining.bus_in_time("viewer", stop, "reflexarc view") as bus:
            bus.subscribe(ON_THE_BUS, _keep(came))
            aside.print(f"reflexarc view: {plain(bus.robot)}/… (Ctrl-C ends it)")
            while came.empty() and not stop():
                time.sleep(POLL_S)
            # Only now is the runtime known, whose policy names the actions.
            actions = action_names(bus.fetch_policy())
            canvas = RerunCanvas(bus.robot, f"live since {time.time():.0f}", actions)
            connect(canvas)
            while not stop():
                with contextlib.suppress(queue.Empty):
                    message = came.get(timeout=POLL_S)
                    name = message.key.removeprefix(f"{bus.robot}/")
                    schema = message.encoding.partition(";")[2]
                    time_ns = message.received_ns + offset_ns
                    show(drawer, canvas, name, schema, message.payload, time_ns)
        canvas.finish()


def _keep(came: "queue.Queue[Message]") -> "Callable[[Message], None]":
    """Puts messages into a queue; where the viewer is too far behind, they are not shown."""

    def hear(message: "Message") -> None:
        with contextlib.suppress(queue.Full):
            came.put_nowait(message)

    return hear
