"""The flag that says how much of a disk a recording leaves free."""

import math
from dataclasses import dataclass
from typing import Annotated

import tyro

from reflexarc_runtime.errors import UsageError

MOST_MB = 1e9


@dataclass(frozen=True)
class Reserve:
    """How much of the disk a recording leaves free."""

    reserve_mb: Annotated[float, tyro.conf.arg(aliases=["--reserve"])] = 64.0
    """A recording stops before less than so many MB (2²⁰ bytes) are free, or a tenth of a small
    disk, so that the rest of the machine lives and the log is finished. 0: until it is full."""

    @property
    def size_bytes(self) -> int:
        """The same in bytes.

        Raises:
            UsageError: it is no size.
        """
        if not (math.isfinite(self.reserve_mb) and 0.0 <= self.reserve_mb <= MOST_MB):
            raise UsageError(f"--reserve-mb: expected 0 to {MOST_MB:g}, got {self.reserve_mb}")
        return round(self.reserve_mb * (1 << 20))
