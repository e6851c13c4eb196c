"""`reflexarc recover`: a log that was cut off or damaged, made whole."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from reflexarc.terminal.output import aside, console, print_json
from reflexarc_runtime.words.suggestion import pasteable


@dataclass(frozen=True)
class RecoverCommand:
    """Save what is intact of a log that was cut off or damaged, as a finished log.

    Every intact record is copied byte for byte, of logs of other systems, too. What is lost is told
    by its place in the file and by topic. The exit status is 0 if all of it was saved; 1 if a log
    was written and something is lost or uncertain, as in any log that was never finished, or if it
    holds no message; 2 if there was nothing to save, and nothing was written.

    Examples:
      reflexarc recover runs/drive.mcap.partial -o runs/drive.mcap
    """

    log: tyro.conf.Positional[Path]
    """The log that was cut off or damaged (MCAP)."""
    out: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """Where to write the finished log; it must not exist yet."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> int:
        """Recover, and say what was saved and what was lost."""
        from reflexarc.terminal.recovery_description import describe_recovery
        from reflexarc_logs.reading.recover import recover

        recovered = recover(self.log, self.out)
        if self.json:
            print_json(recovered)
            return recovered.exit_status
        console.print(describe_recovery(recovered))
        if recovered.is_ours and recovered.messages:
            aside.print(f"try: {pasteable('reflexarc', 'replay', self.out)}", soft_wrap=True)
        return recovered.exit_status
