"""What a sense is told beside the contract: how to read what a driver sends; a log carries it."""

import json
from dataclasses import asdict, dataclass, field
from typing import Self

from reflexarc_runtime.config.fill import fill
from reflexarc_runtime.config.source import MappingSource
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.sensing.mounting import Mount, Sector
from reflexarc_runtime.sensing.range_meaning import RangeMeaning


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

    def to_json(self) -> str:
        """One line, for a log's metadata."""
        return json.dumps(asdict(self), sort_keys=True)

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Read them back.

        Raises:
            LogError: not what `to_json` wrote.
        """
        try:
            document = json.loads(text)
        except (ValueError, RecursionError):
            document = None
        if not isinstance(document, dict):
            raise LogError(f"senses: got {text[:40]!r}; the log is damaged")
        return fill(cls, MappingSource(document, "senses", LogError), require_all=True)
