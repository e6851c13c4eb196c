"""The flags that say how a recording is kept: room, syncs, parts, and how much of them."""

import datetime
import math
import os
import platform
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from reflexarc_logs.recording.keeping import Keeping

MOST_MB = 1e9
MOST_S = 1e7
LEAST_PART_MB = 0.1
LEAST_PART_S = 1.0
"""A loop says once a second what it knows; a part begins with that."""
LEAST_KEPT_MB = 1.0
LOG_SUFFIX = ".mcap"


@dataclass(frozen=True)
class RecordingFlags:
    """How a recording is kept."""

    reserve_mb: Annotated[float, tyro.conf.arg(aliases=["--reserve"])] = 64.0
    """A recording stops before less than so many MB (2²⁰ bytes) are free, or a tenth of a small
    disk, so that the rest of the machine lives and the log is finished. 0: until it is full."""
    sync_s: float = 1.0
    """Have the disk itself keep all at least so often: what a loss of power costs. 0: with
    every flush. A killed process loses 0.8 seconds, whatever this says."""
    rotate_mb: float | None = None
    """Begin a new part, a log of its own, whenever one has so many MB."""
    rotate_s: float | None = None
    """Begin a new part after so many seconds."""
    keep_mb: float | None = None
    """Keep about so many MB: remove the oldest parts, in a folder first those that earlier
    recordings left in it. Without --rotate-mb a part is a tenth of it."""

    def keeping(self, command: str) -> "Keeping":
        """The same for a recorder.

        Args:
            command: which command records, for the manifest.

        Raises:
            UsageError: a number that cannot be meant.
        """
        from reflexarc_logs.recording.keeping import Keeping

        check_number("--reserve-mb", self.reserve_mb, 0.0, MOST_MB)
        check_number("--sync-s", self.sync_s, 0.0, MOST_S)
        check_number("--rotate-mb", self.rotate_mb, LEAST_PART_MB, MOST_MB)
        check_number("--rotate-s", self.rotate_s, LEAST_PART_S, MOST_S)
        check_number("--keep-mb", self.keep_mb, LEAST_KEPT_MB, MOST_MB)
        if self.keep_mb and self.rotate_mb and self.keep_mb < 2.0 * self.rotate_mb:
            raise UsageError(
                f"--keep-mb: expected at least two parts, {2.0 * self.rotate_mb:g}, "
                f"got {self.keep_mb:g}"
            )
        return Keeping(
            reserve_bytes=round(self.reserve_mb * (1 << 20)),
            sync_s=self.sync_s,
            rotate_bytes=size_bytes(self.rotate_mb),
            rotate_s=self.rotate_s,
            keep_bytes=size_bytes(self.keep_mb),
            who=who_removes(command),
        )


def size_bytes(size_mb: float | None) -> int | None:
    """A number of MB in bytes."""
    return None if size_mb is None else round(size_mb * (1 << 20))


def recording_place(place: Path, keeping: "Keeping") -> Path:
    """Where a recording goes: a log, or a folder, which takes many and is made if need be.

    A name without `.mcap` is a folder where it is one already, or where parts are to be expected.

    Raises:
        UsageError: it cannot be made.
    """
    if is_for_folder(place, keeping):
        try:
            place.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise UsageError(f"{place}: cannot be made: {error.strerror}") from None
    return place


def is_for_folder(place: Path, keeping: "Keeping") -> bool:
    """Whether recordings go into a folder there: one more never finds its name taken."""
    from reflexarc_logs.container.first_look import is_folder

    return is_folder(place) or (keeping.in_parts and place.suffix.lower() != LOG_SUFFIX)


def who_removes(command: str) -> str:
    """Who a manifest says removed old parts."""
    return f"{command}, process {os.getpid()} on {platform.node()}"


def now_in_name() -> str:
    """Date and time for a file's name."""
    return datetime.datetime.now().strftime("%Y-%m-%d_%H-%M-%S")


def check_number(flag: str, number: float | None, least: float, most: float) -> None:
    """Refuse a number out of its limits.

    Raises:
        UsageError: it is.
    """
    if number is not None and not (math.isfinite(number) and least <= number <= most):
        raise UsageError(f"{flag}: expected {least:g} to {most:g}, got {number}")
