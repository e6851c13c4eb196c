"""The flags of a black box: the last seconds in memory, written out when something happens."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from reflexarc.wiring.keeping_logs.recording_flags import (
    check_number,
    now_in_name,
    recording_place,
    size_bytes,
)
from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from reflexarc_logs.recording.black_box import BoxSpan
    from reflexarc_logs.recording.keeping import Keeping

MOST_BOX_S = 3600.0
LEAST_BOX_S = 1.0
LEAST_KEPT_MB = 1.0
MOST_KEPT_MB = 1e9


@dataclass(frozen=True)
class BlackBoxFlags:
    """What a black box keeps."""

    black_box: float | None = None
    """Keep the last so many seconds in memory, 256 MiB at most, and write them out at a verdict
    other than OK, a contact, the guard, a stop, or `reflexarc mark`."""
    black_box_after: float = 5.0
    """Write so many seconds behind it as well."""
    black_box_keep_mb: float = 1024.0
    """Remove the oldest of what boxes wrote into this folder beyond so many MB."""
    black_box_out: Annotated[Path | None, tyro.conf.arg(aliases=["-o"])] = None
    """Where the box writes, a folder, or a log (.mcap) whose next ones stand beside it;
    runs/<date and time>-box by default."""

    @property
    def span(self) -> "BoxSpan | None":
        """How much it writes; None: there is no box.

        Raises:
            UsageError: a number that cannot be meant, or a place for no box.
        """
        from reflexarc_logs.recording.black_box import BoxSpan

        if self.black_box is None:
            if self.black_box_out is not None:
                raise UsageError("-o: expected --black-box SECONDS beside it; or --record PATH")
            return None
        check_number("--black-box", self.black_box, LEAST_BOX_S, MOST_BOX_S)
        check_number("--black-box-after", self.black_box_after, 0.0, MOST_BOX_S)
        check_number("--black-box-keep-mb", self.black_box_keep_mb, LEAST_KEPT_MB, MOST_KEPT_MB)
        return BoxSpan(self.black_box, self.black_box_after)

    def keeping(self, of_record: "Keeping") -> "Keeping":
        """How what it writes is kept: on the disk as a recording is, but in parts of its own."""
        most = size_bytes(self.black_box_keep_mb)
        return replace(of_record, rotate_bytes=None, rotate_s=None, keep_bytes=most)

    def place(self, keeping: "Keeping") -> Path:
        """The folder that it will write into, which is made; or its first log.

        Raises:
            UsageError: the folder cannot be made.
        """
        place = self.black_box_out or Path("runs") / f"{now_in_name()}-box"
        return recording_place(place, keeping)
