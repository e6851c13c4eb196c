"""`reflexarc recover`: a log that was cut off or damaged, made whole."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from reflexarc.terminal.output import aside, console, plain, print_json
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.words.suggestion import pasteable


@dataclass(frozen=True)
class RecoverCommand:
    """Save what is intact of a log that was cut off or damaged, as a finished log.

    Every intact record is copied byte for byte, of logs of other systems, too. What is lost is told
    by its place in the file and by topic. The exit status is 0 if all of it was saved; 1 if a log
    was written and something is lost or uncertain, as in any log that was never finished, or if it
    holds no message; 2 if there was nothing to save, and nothing was written.

    Of a folder, all unfinished logs (*.mcap.partial) in it that no living process writes, each to
    its finished name beside it; what was there stays. What was recovered before is left out.

    Examples:
      reflexarc recover runs/drive.mcap.partial -o runs/drive.mcap
      reflexarc recover /var/lib/reflexarc-robot0/logs
    """

    log: tyro.conf.Positional[Path]
    """The log that was cut off or damaged (MCAP), or a folder of unfinished ones."""
    out: Annotated[Path | None, tyro.conf.arg(aliases=["-o"])] = None
    """Where to write the finished log; it must not exist yet. Only of one log."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> int:
        """Recover, and say what was saved and what was lost."""
        from reflexarc_logs.container.first_look import is_folder

        if is_folder(self.log):
            return self._recover_all()
        if self.out is None:
            raise UsageError("recover: expected -o FILE.mcap for one log, or a folder without it")
        return self._recover_one(self.out)

    def _recover_all(self) -> int:
        from reflexarc.wiring.keeping_logs.unfinished_logs import recover_folder

        if self.out is not None:
            raise UsageError("-o: expected one log; those of a folder get their finished names")
        found = recover_folder(self.log)
        if self.json:
            print_json(found)
            return found.exit_status
        for one in found.saved:
            console.print(plain(f"{one.path}: {one.messages} messages"), soft_wrap=True)
        for words in found.refused:
            console.print(plain(words), soft_wrap=True)
        console.print(f"{len(found.saved)} recovered, {len(found.refused)} with nothing to save")
        if found.saved:
            aside.print(f"try: {pasteable('reflexarc', 'replay', self.log)}", soft_wrap=True)
        return found.exit_status

    def _recover_one(self, out: Path) -> int:
        from reflexarc.terminal.recovery_description import describe_recovery
        from reflexarc_logs.reading.recover import recover

        recovered = recover(self.log, out)
        if self.json:
            print_json(recovered)
            return recovered.exit_status
        console.print(describe_recovery(recovered))
        if recovered.is_ours and recovered.messages:
            aside.print(f"try: {pasteable('reflexarc', 'replay', out)}", soft_wrap=True)
        return recovered.exit_status
