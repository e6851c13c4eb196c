"""One circumstance that people of the field reported, tried on the product."""

import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

TIMEOUT_S = 120.0


@dataclass(frozen=True)
class Said:
    """How a command ended, and what it said."""

    status: int
    out: str
    complaint: str

    @property
    def everything(self) -> str:
        """Both streams."""
        return self.out + self.complaint

    @property
    def has_traceback(self) -> bool:
        """Whether a bug showed."""
        return "Traceback" in self.everything


@dataclass(frozen=True)
class Outcome:
    """Whether the right answer came, and the answer in a few words."""

    holds: bool
    seen: str


@dataclass(frozen=True)
class Stage:
    """Where a case is tried."""

    inputs: Path
    """The folder of this case, read only."""
    scratch: Path
    """A folder of its own that is empty, and removed afterwards."""

    def reflexarc(self, *words: object, **surroundings: str) -> Said:
        """Run `reflexarc WORDS` to its end, with these variables set beside the usual ones."""
        return self.command(sys.executable, "-m", "reflexarc", *words, **surroundings)

    def command(self, *words: object, **surroundings: str) -> Said:
        """Run any command to its end, in the scratch folder."""
        ended = subprocess.run(
            [str(word) for word in words],
            capture_output=True,
            text=True,
            errors="replace",
            timeout=TIMEOUT_S,
            cwd=self.scratch,
            env={**os.environ, **surroundings},
            check=False,
        )
        return Said(ended.returncode, ended.stdout, ended.stderr)


Trial: TypeAlias = Callable[[Stage], Outcome]


@dataclass(frozen=True)
class Case:
    """A line of the table."""

    folder: str
    """In the folder of cases; empty if it needs none."""
    circumstance: str
    expected: str
    trial: Trial
