"""Recovers a log that was cut off or damaged: what is intact of it becomes a finished log.

Every intact record is copied byte for byte, ours or not: messages, channels, schemas, attachments,
metadata, and what the format does not know. A chunk whose CRC does not fit is left out and counted;
the log says so, and replay at level `node` refuses it, because an input may be missing.
"""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from reflexarc_logs.container.file_bytes import FileBytes
from reflexarc_logs.container.first_look import Survey, look
from reflexarc_logs.container.frames import NotReadHereError
from reflexarc_logs.container.index import Index, likely_index, read_index
from reflexarc_logs.container.raw_log import RawLog
from reflexarc_logs.container.writing import END
from reflexarc_logs.reading.losses import LossAccount, LossPlace, LostPart, by_topic
from reflexarc_logs.reading.rescue import Rescue
from reflexarc_logs.salvaging.salvage import Salvage
from reflexarc_runtime.errors import LogError

UNFINISHED = ".recovering"
"""Not the recorder's suffix: `log.mcap.partial` is recovered to `log.mcap`, and is kept."""


@dataclass(frozen=True)
class Recovered:
    """What was saved, and what was not."""

    path: Path
    """The finished log."""
    is_ours: bool
    """Whether reflexarc recorded it; the records of any other system are kept as well."""
    messages: int
    losses: tuple[LostPart, ...]
    """In the order of the file."""
    lost_by_topic: Mapping[str, int]
    """Messages that are known to be lost."""
    lost_bytes: int
    """Bytes of the broken log that could not be read."""
    damaged_chunks: int
    """Chunks, or parts of the file that may have been some, that are missing before its end."""
    nameless_channels: int
    """Channels whose messages are kept and whose own records, with topic and schema, are lost."""
    doubt: str
    """What may have changed without a trace; empty: nothing."""
    was_complete: bool
    """Whether there was nothing to recover."""

    @property
    def exit_status(self) -> int:
        """0: all is saved. 1: something is lost or in doubt, or there is no message at all."""
        whole = self.messages and not self.losses and not self.nameless_channels and not self.doubt
        return 0 if whole else 1


def recover(path: Path | str, out: Path | str) -> Recovered:
    """Write what is intact of a log into a finished one.

    Args:
        path: the log that was cut off, or a `.partial`; of any system.
        out: the log to be; it must not exist.

    Raises:
        LogError: nothing in it can be saved, or `out` cannot be written.
    """
    source, found = Path(path), look(Path(path))
    index = likely_index(source)
    target = RawLog(Path(out), UNFINISHED)
    try:
        with source.open("rb") as file:
            recovered = _recovered(file, found, index, target)
        target.finish()
    except NotReadHereError as error:
        target.discard()
        raise LogError(f"{path}: {error}; nothing was saved") from None
    except OSError as error:
        target.discard()
        raise LogError(f"{out}: cannot be written: {error.strerror}; nothing was saved") from None
    except BaseException:
        target.discard()
        raise
    _verify(Path(out))
    return recovered


def _recovered(file: BinaryIO, found: Survey, index: Index | None, target: RawLog) -> Recovered:
    data, account = FileBytes(file), LossAccount()
    whole = found.data_ended and found.has_data_crc
    salvage = Salvage(data, whole, index)
    rescue = Rescue(data, target, account, index, whole)
    for record in salvage.walk():
        rescue.take(record)
    if not rescue.records and not found.complete:
        raise LogError(_nothing(found, account))
    if index is None and salvage.has_ended:
        index = read_index(found.path, salvage.end)
    is_explained = account.first != "" or rescue.index_differs
    counts, doubt = None, _contradiction(index, target, rescue) or _unknown(salvage)
    if index is not None and index.is_proven and not (found.complete and account.first == ""):
        counts = index.counts
        if index.totals == target.totals:
            is_explained |= index.is_shifted
            account.drop_what_was_index()
    if not rescue.ends_in_hole:
        _add_the_end(salvage, found, account)
    losses = account.losses(target.counts, counts, rescue.topics)
    inside = (LossPlace.BEGINNING, LossPlace.MIDDLE, LossPlace.UNKNOWN)
    missing = sum(loss.place in inside and loss.messages != 0 for loss in losses)
    if missing:
        target.describe(END, {"damaged_chunks": str(missing)})
    return Recovered(
        path=target.file.path,
        is_ours=found.is_ours or rescue.is_ours,
        messages=target.counts.total(),
        losses=losses,
        lost_by_topic=by_topic(losses),
        lost_bytes=sum(loss.bytes for loss in losses),
        damaged_chunks=missing,
        nameless_channels=len(rescue.nameless),
        doubt=doubt or ("" if is_explained else _doubt(found, salvage)),
        was_complete=found.complete and not losses,
    )


def _add_the_end(salvage: Salvage, found: Survey, account: LossAccount) -> None:
    """Note what is missing at the end of the file, or stands behind it."""
    if not salvage.has_ended:
        account.add("it was never finished, or is cut off", 0, 0, LossPlace.END)
    elif found.behind:
        what = "another log" if found.is_log_behind else "bytes that belong to no log"
        account.add(f"{what}, not read", found.behind, 0, LossPlace.BEHIND)


def _doubt(found: Survey, salvage: Salvage) -> str:
    """What the CRC of all data says, where nothing that is lost explains it."""
    if found.data_ended or not salvage.has_ended:
        return ""
    return f"{found.damage}: what stands outside of its chunks may have changed"


def _contradiction(index: Index | None, target: RawLog, rescue: Rescue) -> str:
    """What an index says otherwise than the data, if it has no CRC: one of both has changed."""
    if index is None or index.is_proven:
        return ""
    counts = index.counts
    differs = counts is not None and +Counter(counts) != target.counts
    if not rescue.contradictions and not differs:
        return ""
    return "its index, which has no CRC, says other than its data: one of both has changed"


def _unknown(salvage: Salvage) -> str:
    if not salvage.in_doubt:
        return ""
    return f"{salvage.in_doubt} records of an unknown kind may be messages that were changed"


def _nothing(found: Survey, account: LossAccount) -> str:
    if not found.is_mcap:
        return f"{found.path}: expected an MCAP file, got another kind of file"
    why = found.refusal or found.damage or "it holds nothing"
    return f"{found.path}: nothing to save: {account.first or why}"


def _verify(out: Path) -> None:
    """Read the recovered log back: its frame and its CRC."""
    found = look(out)
    if not found.complete:
        raise LogError(f"{out}: read back, it is not whole: {found.damage}; keep both files")
