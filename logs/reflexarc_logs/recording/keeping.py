"""How a recording is kept: what stays free, how often it is synced, when a new part begins."""

from dataclasses import dataclass

from reflexarc_logs.recording.place import DEFAULT_RESERVE_BYTES

DEFAULT_SYNC_S = 1.0
KEPT_PARTS = 10
"""Where only the total is limited, a part is a tenth of it: so much is lost of the oldest at once.
"""


@dataclass(frozen=True)
class Keeping:
    """How a recording is kept. By default: one part, of any length, and nothing is removed."""

    reserve_bytes: int = DEFAULT_RESERVE_BYTES
    """What shall stay free on the disk, at most a tenth of it."""
    sync_s: float = DEFAULT_SYNC_S
    """What a machine that loses its power may lose; 0: it is synced with every flush."""
    rotate_bytes: int | None = None
    """A part that is larger is finished, and the next one begun."""
    rotate_s: float | None = None
    """The same by its length, in the log's own time."""
    keep_bytes: int | None = None
    """What all parts may have together: beyond it the oldest are removed. In a folder, those of
    earlier recordings count, and go first."""
    who: str = ""
    """Who removes them, for the manifest."""

    @property
    def in_parts(self) -> bool:
        """Whether there will be parts if nothing fails."""
        return any(x is not None for x in (self.rotate_bytes, self.rotate_s, self.keep_bytes))

    @property
    def most_bytes(self) -> int | None:
        """How large a part may be."""
        if self.rotate_bytes is None and self.keep_bytes is not None:
            return self.keep_bytes // KEPT_PARTS
        return self.rotate_bytes

    def exceeded(self, size_bytes: int, length_s: float) -> str:
        """Which limit a part has reached, in words; empty if none."""
        most_bytes = self.most_bytes
        if most_bytes is not None and size_bytes >= most_bytes:
            return f"{most_bytes / (1 << 20):g} MB"
        if self.rotate_s is not None and length_s >= self.rotate_s:
            return f"{self.rotate_s:g} s"
        return ""


DEFAULT_KEEPING = Keeping()
