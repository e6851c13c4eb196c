"""`reflexarc record`: writes every stream of a robot on the bus into one log."""

import math
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from reflexarc.terminal.output import aside, console, facts, print_json
from reflexarc.terminal.signals import StopFlag
from reflexarc.wiring.bus_flags import Joining
from reflexarc.wiring.keeping_logs.recording_flags import (
    RecordingFlags,
    now_in_name,
    recording_place,
)
from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from reflexarc.wiring.keeping_logs.outcome import Recording

POLL_S = 0.05


@dataclass(frozen=True)
class RecordCommand:
    """Record every stream of a robot on the bus, until Ctrl-C.

    The log holds what this process heard, in its own order; it replays at level `policy`. A log
    that replays at level `node` too is made by `reflexarc run --record`. A recording that fails,
    for example on a full disk, goes on in NAME.part2.mcap once it can; so does one with a limit for
    its parts. Exit status 1: it failed,
    or a part of it is missing.

    Examples:
      reflexarc record
      reflexarc record -o runs/monday.mcap --robot rover1
      reflexarc record -o runs/monday --rotate-mb 100 --keep-mb 2000
    """

    out: Annotated[Path | None, tyro.conf.arg(aliases=["-o"])] = None
    """Where to write; runs/<date and time>.mcap by default. A folder, made with --rotate-mb,
    --rotate-s or --keep-mb, takes many recordings."""
    seconds: float | None = None
    """End after so many seconds; by default, at Ctrl-C."""
    recording: tyro.conf.OmitArgPrefixes[RecordingFlags] = field(default_factory=RecordingFlags)
    joining: Joining = field(default_factory=Joining)
    json: bool = False
    """Print one JSON object at the end."""

    def run(self) -> int:
        """Record until the end."""
        from reflexarc.wiring.keeping_logs.outcome import recording_of
        from reflexarc.wiring.keeping_logs.recorders import recorder_of_bus
        from reflexarc.wiring.waiting import Arrival, Waiting, Wish
        from reflexarc_runtime.messages.topics import ON_THE_BUS, RECORDER_NODE

        if self.seconds is not None and not 0.0 < self.seconds < math.inf:
            raise UsageError(f"--seconds: expected a positive number, got {self.seconds}")
        keeping = self.recording.keeping("reflexarc record")
        place = recording_place(self.out or Path("runs") / f"{now_in_name()}.mcap", keeping)
        if self.out is None:
            place.parent.mkdir(exist_ok=True)
        with (
            StopFlag() as stop,
            self.joining.bus_in_time(RECORDER_NODE, stop, "reflexarc record") as bus,
        ):
            policy = bus.fetch_policy() or b""
            with recorder_of_bus(place, policy, self.joining.robot, keeping) as recorder:
                came = Arrival(recorder.put)
                bus.subscribe(ON_THE_BUS, came.hear)
                aside.print(f"reflexarc record: {recorder.path} (Ctrl-C ends it)")
                wish = Wish("reflexarc record", "messages", f"{bus.robot}/…")
                with Waiting(bus, wish, came):
                    self._wait(stop)
        recording = recording_of(recorder)
        self._tell(recorder.path, recording)
        return int(recording.failed)

    def _wait(self, stop: StopFlag) -> None:
        """Wait for the end; a recording that stopped may go on in a new part."""
        end_s = None if self.seconds is None else time.monotonic() + self.seconds
        while not stop() and (end_s is None or time.monotonic() < end_s):
            time.sleep(POLL_S)

    def _tell(self, path: Path, recording: "Recording") -> None:
        if self.json:
            print_json({"log": path, "state": recording.state, "parts": recording.parts})
        else:
            console.print(facts({"log": path, "recording": recording.in_words}))
