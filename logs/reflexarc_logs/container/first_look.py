"""The first look at a log: is it whole, is it ours, and what does it say about itself?

One pass that unpacks no message: frame, CRC of the data, attachments and metadata.
"""

from dataclasses import dataclass, field
from pathlib import Path

from mcap.records import Attachment, DataEnd, Footer, McapRecord, Metadata

from reflexarc_logs.container.record_stream import (
    DamagedError,
    NotMcapError,
    TruncatedError,
    stream_records,
)
from reflexarc_logs.container.run_info import RUN, RunInfo
from reflexarc_logs.container.writing import CONFIG_ATTACHMENT, END, POLICY_ATTACHMENT
from reflexarc_runtime.errors import LogError

_ATTACHMENTS = (POLICY_ATTACHMENT, CONFIG_ATTACHMENT)


@dataclass
class Survey:
    """What one pass over the file found."""

    size: int
    attachments: dict[str, bytes] = field(default_factory=dict)
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    complete: bool = False
    intact_size: int = 0
    damage: str = ""
    """Why it is not complete."""
    data_ended: bool = False
    """Whether all messages are there, even if the index after them is damaged."""

    @property
    def run(self) -> RunInfo:
        """What the log says about its run.

        Raises:
            LogError: a malformed field.
        """
        return RunInfo.from_metadata(self.metadata[RUN])

    @property
    def dropped(self) -> int:
        """Records and chunks that the log says are missing in its middle."""
        end = self.metadata.get(END, {})
        return sum(_count(end.get(name, "0")) for name in ("dropped", "damaged_chunks"))


def survey(path: Path, *, salvage: bool = False) -> Survey:
    """Look a log over.

    Args:
        path: the file.
        salvage: whether to stop at damage and keep what is before it; else damage is an error.

    Raises:
        LogError: the file is missing, unreadable, empty or not MCAP; another system wrote it; it is
            damaged, and `salvage` is not set.
    """
    found = Survey(size=_size(path))
    try:
        for located in stream_records(path):
            _note(found, located.record)
            found.intact_size = located.end
    except NotMcapError:
        raise LogError(f"{path}: expected an MCAP file, got another kind of file") from None
    except TruncatedError:
        found.complete = False
        found.damage = f"it ends in the middle, after {found.intact_size} intact bytes"
    except DamagedError as error:
        found.complete = False
        found.damage = str(error)
        if not salvage:
            raise LogError(
                f"{path}: damaged: {error}; `reflexarc recover` saves the rest"
            ) from None
    except OSError as error:
        raise LogError(f"{path}: cannot be read: {error.strerror}") from None
    if not found.complete and not found.damage:
        found.damage = "its data has no end"
    if RUN not in found.metadata:
        raise LogError(_foreign(path, found))
    return found


def _size(path: Path) -> int:
    try:
        size = path.stat().st_size
    except OSError as error:
        raise LogError(f"{path}: cannot be read: {error.strerror}; give a log (.mcap)") from None
    if not size:
        raise LogError(f"{path}: expected a log, got an empty file")
    return size


def _note(found: Survey, record: McapRecord) -> None:
    if isinstance(record, Metadata) and record.name == END:
        found.metadata[END] = record.metadata  # said again whenever more is missing
    elif isinstance(record, Metadata):
        found.metadata.setdefault(record.name, record.metadata)
    elif isinstance(record, Attachment) and record.name in _ATTACHMENTS:
        found.attachments.setdefault(record.name, record.data)
    elif isinstance(record, DataEnd):
        found.data_ended = True
    elif isinstance(record, Footer):
        found.complete = found.data_ended


def _count(text: str) -> int:
    """A count of missing records; one that cannot be read stands for at least one."""
    return int(text) if text.isascii() and text.isdigit() and len(text) < 20 else 1


def _foreign(path: Path, found: Survey) -> str:
    if not found.complete:
        return f"{path}: truncated before it says whose it is ({found.damage}); nothing to save"
    return f"{path}: expected a log of reflexarc, got one of another system (no {RUN} metadata)"
