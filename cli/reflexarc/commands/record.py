"""x."""
from dataclasses import dataclass
from pathlib import Path
import tyro
@dataclass(frozen=True)
class Record:
    """Do the record.

    Examples:
      reflexarc record x
    """
    log: tyro.conf.Positional[Path]
    """The log."""
    level: str = "a"
    """Level."""
    json: bool = False
    """Print json."""
    def run(self) -> int:
        """R."""
        print(self)
        return 0
