"""What the first records of a part say: of which run it is, and which part."""

from pathlib import Path

from mcap.opcode import Opcode
from mcap.records import Metadata

from reflexarc_logs.container.fields import decoded
from reflexarc_logs.container.frames import (
    DamagedError,
    FrameReader,
    NotMcapError,
    NotReadHereError,
    TruncatedError,
)
from reflexarc_logs.container.run_info import RUN
from reflexarc_logs.recording.part import PART

_HEAD_RECORDS = 3
"""The header, of which run it is, which part it is."""


def says_it_is(path: Path, run_id: str, number: int) -> bool:
    """Whether a log says that it is this part of this run; an empty file says nothing else.

    Raises:
        OSError: it cannot be read.
    """
    size_bytes = path.stat(follow_symlinks=False).st_size
    if not size_bytes:
        return True  # its recorder was killed before it wrote a byte
    said = _metadata(path, size_bytes)
    is_part = said.get(PART, {}).get("part", "1") == str(number)
    return is_part and said.get(RUN, {}).get("run_id") == run_id


def _metadata(path: Path, size_bytes: int) -> dict[str, dict[str, str]]:
    """Of the first records, as far as they can be read."""
    said: dict[str, dict[str, str]] = {}
    try:
        with path.open("rb") as file:
            reader = FrameReader(file, size_bytes)
            reader.magic()
            for _ in range(_HEAD_RECORDS):
                frame = reader.frame()
                if frame.opcode not in (Opcode.HEADER, Opcode.METADATA):
                    break
                record = decoded(frame.opcode, reader.fields(frame))
                if isinstance(record, Metadata):
                    said[record.name] = record.metadata
    except (DamagedError, NotMcapError, NotReadHereError, TruncatedError):
        pass
    return said
