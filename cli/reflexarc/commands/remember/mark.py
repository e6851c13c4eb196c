"""`reflexarc mark`: a remark of a person, written into the logs that are being recorded."""

import time
from dataclasses import dataclass, field

import tyro

from reflexarc.terminal.output import console, plain
from reflexarc.wiring.bus_flags import Joining
from reflexarc_runtime.errors import BusError, UsageError

MAX_CHARACTERS = 500
POLL_S = 0.02


@dataclass(frozen=True)
class MarkCommand:
    """Put a mark into the logs that are being recorded, at this moment.

    Viewers show it among the robot's messages; `reflexarc incident LOG --first mark` finds it.
    Exit status 2 if nobody records.

    Examples:
      reflexarc mark "it should have turned here"
      reflexarc mark "rain begins" --robot rover1
    """

    text: tyro.conf.Positional[str]
    """What to write."""
    joining: Joining = field(default_factory=Joining)
    patience: float = 3.0
    """Seconds to wait for somebody who records."""

    def run(self) -> int:
        """Say it once somebody listens."""
        from foxglove_schemas_protobuf.Log_pb2 import Log

        from reflexarc_runtime.messages.topics import MARK, OPERATOR

        if not 0 < len(self.text.strip()) <= MAX_CHARACTERS:
            raise UsageError(f"expected a text of 1 to {MAX_CHARACTERS} characters")
        if not 0.0 < self.patience <= 3600.0:
            raise UsageError(f"--patience: expected above 0 to 3600 s, got {self.patience}")
        said = Log(level=Log.INFO, message=plain(self.text), name="mark")
        said.timestamp.FromNanoseconds(time.time_ns())
        with self.joining.bus(OPERATOR) as bus:
            publisher, end_s = bus.publisher(MARK), time.monotonic() + self.patience
            while not publisher.has_listener:
                if time.monotonic() >= end_s:
                    key = MARK.key(bus.robot)
                    raise BusError(
                        f"nobody records {key} within {self.patience:g} s; expected "
                        "`reflexarc run … --record` or `reflexarc record`"
                    )
                time.sleep(POLL_S)
            publisher.put(said.SerializeToString(), time.monotonic_ns())
        console.print(f"{self.joining.robot}: marked", highlight=False)
        return 0
