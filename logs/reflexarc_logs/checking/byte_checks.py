"""Whether the bytes of an MCAP file are those that were written: CRCs, attachments, its index."""

from collections.abc import Iterator
from pathlib import Path

from mcap.opcode import Opcode

from reflexarc_logs.checking.findings import LogFinding, error
from reflexarc_logs.container.attachments import attached_at, is_intact
from reflexarc_logs.container.first_look import Survey
from reflexarc_logs.container.frames import DamagedError, FrameReader, TruncatedError
from reflexarc_logs.container.index import read_index
from reflexarc_logs.container.remedy import recovery


def frame_findings(found: Survey) -> Iterator[LogFinding]:
    """What the first look found amiss: an end that is missing, a CRC that does not fit."""
    remedy = f"; {recovery(found.path)} saves the rest"
    if found.is_cut:
        yield error("completeness", f"it was never finished: {found.damage}{remedy}")
    elif found.damage:
        yield error("bytes", f"{found.damage}{remedy}")


def attachment_findings(path: Path, end: int) -> Iterator[LogFinding]:
    """Attachments whose CRC does not fit, up to a place in the file.

    Raises:
        OSError: the file cannot be read.
    """
    with path.open("rb") as file:
        reader = FrameReader(file, end)
        try:
            reader.magic()
            while reader.left:
                frame = reader.frame()
                if frame.opcode == Opcode.ATTACHMENT:
                    attached = attached_at(file, frame)
                    if not is_intact(file, frame, attached):
                        yield error("bytes", f"the CRC of attachment {attached.name} does not fit")
                    file.seek(reader.position)
                reader.seek_behind(frame)
        except (DamagedError, TruncatedError):
            return  # the first look said so


def index_findings(path: Path, messages: int) -> Iterator[LogFinding]:
    """Whether there is as much as the file's own index says.

    Args:
        path: a file that is whole; an index is nothing that it must have.
        messages: how many were read.
    """
    index = read_index(path)
    said = None if index is None else index.totals
    if said is not None and said[0] != messages:
        yield error("completeness", f"{messages} messages, but by its own statistics {said[0]}")
