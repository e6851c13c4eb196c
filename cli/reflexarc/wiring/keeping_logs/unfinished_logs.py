"""Logs in a folder that were never finished: said where they are left out, recovered at once."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from reflexarc.terminal.output import aside
from reflexarc_logs.container.first_look import is_folder
from reflexarc_logs.reading.log_paths import unfinished_in
from reflexarc_logs.reading.recover import Recovered, recover
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.words.suggestion import pasteable


@dataclass(frozen=True)
class RecoveredFolder:
    """What became of the unfinished logs of a folder."""

    folder: Path
    saved: tuple[Recovered, ...] = ()
    refused: tuple[str, ...] = ()
    """Why nothing could be saved of others, a line each."""

    @property
    def exit_status(self) -> int:
        """0: all is saved, or there was nothing to do. 1: not all."""
        return max((bool(self.refused), *(each.exit_status for each in self.saved)))


def recover_folder(folder: Path) -> RecoveredFolder:
    """Recover each log that no living process writes to its finished name, beside it.

    One without a message is no log of anything: it would only fail whatever replays the folder.
    """
    saved, refused = list[Recovered](), list[str]()
    for partial in unfinished_in(folder):
        try:
            recovered = recover(partial, partial.with_suffix(""))
        except LogError as error:
            refused.append(str(error))
            continue
        if recovered.messages:
            saved.append(recovered)
        else:
            recovered.path.unlink()
            refused.append(f"{partial}: nothing to save: it holds no message")
    return RecoveredFolder(folder, tuple(saved), tuple(refused))


def say_what_is_left_out(command: str, places: Sequence[Path]) -> None:
    """Say of each folder how many logs in it are left out, as they were never finished."""
    for folder in filter(is_folder, places):
        count = len(unfinished_in(folder))
        if count:
            logs = "1 unfinished log is" if count == 1 else f"{count} unfinished logs are"
            remedy = pasteable("reflexarc", "recover", folder)
            aside.print(f"reflexarc {command}: {logs} left out: `{remedy}`", soft_wrap=True)
