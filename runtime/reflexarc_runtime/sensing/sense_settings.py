"""What a sense is told beside the contract: how to read what a driver sends; a log carries it."""

import math
from dataclasses import dataclass, field
from functools import partial
from typing import Self

from reflexarc_runtime.config.checks import require
from reflexarc_runtime.config.one_line import from_one_line, in_one_line
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.sensing.mounting import Mount, Sector
from reflexarc_runtime.sensing.range_meaning import RangeMeaning

_ADDED_LATER: dict[str, object] = {"frozen_after_s": None, "least_returns": None}
"""What logs of before do not say, with what it was."""

_require = partial(require, error=UsageError)


@dataclass(frozen=True)
class SenseSettings:
    """How a sense reads what comes; by default nothing is believed that was not said."""

    allow_unstated_eye: bool = False
    """Whether a retina that does not say which eye made it is taken for one of the contract's."""
    mount: Mount | None = None
    """How the scanner sits; None: as each scan says."""
    ignored: tuple[Sector, ...] = ()
    """Sectors in which the scanner sees its own robot."""
    meaning: RangeMeaning = field(default_factory=RangeMeaning)
    """What the scanner's driver means by its numbers."""
    frozen_after_s: float | None = None
    """A picture that never changes for so long while the body is told to drive is that of a driver
    that hangs; None: nobody asks."""
    least_returns: float | None = None
    """Of all beams of a scan, as a share: fewer returns are those of a scanner that is covered or
    broken; None: nobody asks."""

    def __post_init__(self) -> None:
        frozen_s, share = self.frozen_after_s, self.least_returns
        fits = frozen_s is None or 0.0 < frozen_s < math.inf
        _require(fits, "--frozen-after", "more than 0 s, and finite", frozen_s)
        fits = share is None or 0.0 < share <= 1.0
        _require(fits, "--least-returns", "a share above 0, at most 1", share)

    def to_json(self) -> str:
        """One line, for a log's metadata."""
        return in_one_line(self)

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Read them back.

        Raises:
            LogError: not what `to_json` wrote.
        """
        return from_one_line(cls, text, "senses", _ADDED_LATER)
