"""`reflexarc play`: sends the sensor streams of a log on the bus again."""

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import tyro

from reflexarc.terminal.keyboard import Keys
from reflexarc.terminal.output import aside, console, facts, microseconds, print_json, progress_bar
from reflexarc.terminal.signals import StopFlag
from reflexarc.wiring.bus_flags import Joining, waiting_for_commands
from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from reflexarc_logs.playing.player import PlaybackReport
    from reflexarc_logs.playing.schedule import Due, StreamSurvey
    from reflexarc_logs.reading.reader import Log
    from reflexarc_runtime.bus import Bus

MAX_SPEED = 1000.0
MS = 1_000_000


@dataclass(frozen=True)
class PlayCommand:
    """Send the sensor streams of a log on the bus again, as its body did.

    These are retina, scan, pose, tf, odometry, contact, scene and body, and nothing of the runtime.
    In real time the messages carry the time of the player's own clock, and no process waits for
    another. In lockstep they carry the log's time, and after each retina or scan the player waits
    for its command. At a terminal the space bar pauses and q quits. Records that cannot be decoded
    are counted and not sent.

    Examples:
      reflexarc play runs/drive.mcap
      reflexarc play runs/intel.mcap --speed 5 --loop
      reflexarc play runs/intel.mcap --lockstep
    """

    log: tyro.conf.Positional[Path]
    """The log (MCAP): recorded or imported."""
    speed: float = 1.0
    """How much faster than it was recorded."""
    loop: bool = False
    """Begin again at the end, until Ctrl-C."""
    lockstep: bool = False
    """Wait for the command of every retina or scan; time is the log's."""
    joining: Joining = field(default_factory=Joining)
    json: bool = False
    """Print one JSON object at the end."""

    def run(self) -> int:
        """Play to the end, then say what was sent and how late."""
        from reflexarc_logs.playing.schedule import survey_streams
        from reflexarc_logs.reading.reader import read_log
        from reflexarc_runtime.messages.topics import BODY_NODE

        self._check_flags()
        log = read_log(self.log)
        streams = survey_streams(log)
        session = self.joining.bus(BODY_NODE, listens=True, lockstep=self.lockstep)
        with StopFlag() as stop, session as bus, Keys() as keys:
            aside.print(
                f"reflexarc play: {self.log}, {streams.messages} messages in "
                f"{streams.length_ns / 1e9:.1f} s (space pauses, q quits)"
            )
            account = self._play(bus, log, streams, stop, keys)
        self._tell(account, streams)
        return 0

    def _check_flags(self) -> None:
        if not (math.isfinite(self.speed) and 0.0 < self.speed <= MAX_SPEED):
            raise UsageError(f"--speed: expected 0 to {MAX_SPEED:g}, got {self.speed}")
        if self.lockstep and self.speed != 1.0:
            raise UsageError("--speed: lockstep is as fast as it can be; leave one of the two out")

    def _play(
        self, bus: "Bus", log: "Log", streams: "StreamSurvey", stop: StopFlag, keys: Keys
    ) -> "PlaybackReport":
        from reflexarc.wiring.playing_body import PlayingBody
        from reflexarc_logs.playing.player import Player
        from reflexarc_logs.playing.schedule import schedule
        from reflexarc_runtime.loop.clock import MonotonicClock

        def should_stop() -> bool:
            return stop() or keys.wants_to_quit()

        body = PlayingBody(bus, streams.sensor, should_stop)
        due = schedule(log, streams, speed=self.speed, loop=self.loop)
        if self.lockstep:
            aside.print(f"reflexarc play: waiting for a runtime in lockstep ({streams.sensor}) …")
            with waiting_for_commands(bus, "reflexarc play", body.is_heard):
                body.wait_for_runtime()
        with self._progress(streams) as saw:
            player = Player(
                MonotonicClock(),
                body.publish,
                should_stop=should_stop,
                is_paused=keys.is_paused,
                saw=saw,
            )
            if not self.lockstep:
                return player.play(due)
            return player.play_in_lockstep(
                due, streams.first_ns, streams.sensor, body.await_command
            )

    @contextmanager
    def _progress(self, streams: "StreamSurvey") -> "Iterator[Callable[[Due], None]]":
        """A bar that shows how far into the log the player is."""
        total_ms = max(1, (streams.length_ns + streams.interval_ns) // MS)
        with progress_bar("playing", total_ms) as show:
            yield lambda due: show(round(due.due_ns * self.speed) // MS % total_ms, total_ms)

    def _tell(self, account: "PlaybackReport", streams: "StreamSurvey") -> None:
        if self.json:
            print_json({**asdict(account), "undecodable": streams.undecodable})
            return
        rows: dict[str, object] = {
            "sent": ", ".join(f"{name} {count}" for name, count in account.messages.items()),
            "not sent": f"{streams.undecodable} undecodable",
            "time": f"{account.seconds:.1f} s, {account.loops} times to the end",
        }
        if not self.lockstep:
            rows["lateness"] = (
                f"p50 {microseconds(account.lateness_p50_ns)}, "
                f"p99 {microseconds(account.lateness_p99_ns)}, "
                f"max {microseconds(account.lateness_max_ns)}"
            )
        console.print(facts(rows))
