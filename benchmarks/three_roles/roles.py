"""What a sensor, a brain and a body are, whatever carries their messages.

    retina    sequence, time of sending, 16 bytes of picture
    command   sequence and time of sending of the retina that led to it, action

All times are of the machine's monotonic clock, in nanoseconds. It needs NumPy alone, so that it
runs in any framework's environment.
"""

import argparse
import os
import struct
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

RETINA = struct.Struct("<qq16s")
COMMAND = struct.Struct("<qqq")
PICTURE = bytes([40] * 16)
"""All that it sees is far away."""
STOP = -1
"""Action of a brain that no longer trusts its picture; the others drive."""
UNKNOWN = -1
"""Lateness of a wake-up whose due time the framework does not tell."""
ROWS = 400_000


class Options(NamedTuple):
    """How a role is told what to do."""

    role: str
    folder: Path
    rate_hz: float
    variant: str
    port: int

    @property
    def period_ns(self) -> int:
        """Between two retinas, and between two wake-ups of the brain."""
        return round(1e9 / self.rate_hz)


def options() -> Options:
    """Read the command line of a role, and leave the process's number in the folder."""
    parser = argparse.ArgumentParser()
    parser.add_argument("role", choices=("sensor", "brain", "body"))
    parser.add_argument("--folder", type=Path, required=True)
    parser.add_argument("--rate-hz", type=float, required=True)
    parser.add_argument("--variant", required=True)
    parser.add_argument("--port", type=int, default=0)
    found = Options(**vars(parser.parse_args()))
    (found.folder / f"{found.role}.pid").write_text(str(os.getpid()))
    return found


class Track:
    """Rows of numbers in a file, which outlive the process that writes them."""

    def __init__(self, path: Path, columns: int) -> None:
        shape = (ROWS, columns)
        self._rows = np.lib.format.open_memmap(path, mode="w+", dtype=np.int64, shape=shape)
        self._count = 0

    def add(self, *row: int) -> None:
        """Append a row, whose first number is not 0."""
        if self._count < ROWS:
            self._rows[self._count] = row
            self._count += 1


class Body:
    """Notes when a command came, when the retina that led to it was sent, and whether it drives."""

    def __init__(self, folder: Path) -> None:
        self._track = Track(folder / "commands.npy", 3)

    def hear(self, payload: bytes) -> None:
        """Take a command."""
        now_ns = time.monotonic_ns()
        _, sent_ns, action = COMMAND.unpack(payload)
        self.note(now_ns, sent_ns, action != STOP)

    def note(self, now_ns: int, sent_ns: int, drives: bool) -> None:
        """Write down a command that was taken."""
        self._track.add(now_ns, sent_ns, drives)


class Brain:
    """A small network in NumPy, and the last retina.

    Args:
        folder: where `network.npz` lies.
        most_age_ns: it says stop on an older retina; 0: it does not look at the age.
    """

    def __init__(self, folder: Path, most_age_ns: int = 0) -> None:
        weights = np.load(folder / "network.npz")
        self._layers = [weights[name] for name in ("w1", "b1", "w2", "b2")]
        self._most_age_ns = most_age_ns
        self._wakes = Track(folder / "wakes.npy", 2)
        self._last: tuple[int, int, bytes] | None = None
        self.lost_sensor = False

    def see(self, payload: bytes) -> None:
        """Keep a retina until the next one comes."""
        self._last = RETINA.unpack(payload)

    def wake(self, late_ns: int = UNKNOWN) -> None:
        """Note a wake-up, and how late it is where the framework says it."""
        self._wakes.add(time.monotonic_ns(), late_ns)

    def decide(self) -> bytes | None:
        """The command on the last retina; None if none came yet."""
        if self._last is None:
            return None
        number, sent_ns, picture = self._last
        old = 0 < self._most_age_ns < time.monotonic_ns() - sent_ns
        action = STOP if old or self.lost_sensor else self._action(picture)
        return COMMAND.pack(number, sent_ns, action)

    def _action(self, picture: bytes) -> int:
        w1, b1, w2, b2 = self._layers
        seen = np.frombuffer(picture, np.uint8).astype(np.float32) / np.float32(255.0)
        return int(np.argmax(w2 @ np.maximum(w1 @ seen + b1, 0.0) + b2))


def send_retinas(send: Callable[[bytes], object], period_ns: int) -> None:
    """Send retinas at absolute times for ever; times that were missed are left out."""
    due_ns, number = time.monotonic_ns(), 0
    while True:
        send(RETINA.pack(number, time.monotonic_ns(), PICTURE))
        number, now_ns = number + 1, time.monotonic_ns()
        due_ns += max(1, 1 + (now_ns - due_ns - 1) // period_ns) * period_ns
        time.sleep(max(0, due_ns - now_ns) * 1e-9)
