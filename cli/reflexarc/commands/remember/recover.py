"""`reflexarc recover`: a log that was cut off, made whole."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from reflexarc.terminal.output import aside, console, facts, kibibytes, print_json
from reflexarc_runtime.words.suggestion import pasteable


@dataclass(frozen=True)
class RecoverCommand:
    """Save what is intact of a log that was cut off, as a finished log.

    Examples:
      reflexarc recover runs/drive.mcap.partial -o runs/drive.mcap
    """

    log: tyro.conf.Positional[Path]
    """The log that was cut off."""
    out: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """Where to write the finished log; it must not exist yet."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> int:
        """Recover, and say what was saved and what was lost."""
        from reflexarc_logs.reading.recover import recover

        recovered = recover(self.log, self.out)
        if self.json:
            print_json(recovered)
            return 0
        console.print(
            facts(
                {
                    "messages": recovered.messages,
                    "lost at the end": kibibytes(recovered.lost_bytes),
                    "written": self.out,
                }
            )
        )
        aside.print(f"try: {pasteable('reflexarc', 'replay', self.out)}", soft_wrap=True)
        return 0
