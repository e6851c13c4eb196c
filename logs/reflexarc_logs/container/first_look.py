"""The first look at a log: is it whole, is it ours, and what does it say about itself?

One pass that unpacks nothing: frame, CRC of the data, places of attachments, and metadata.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

from mcap.opcode import Opcode
from mcap.records import DataEnd, Header, Metadata

from reflexarc_logs.container.agreement import Passed, disagreement
from reflexarc_logs.container.attachments import (
    MOST_OF_A_NAME,
    Attached,
    Attachments,
    attached_at,
    nth_name,
)
from reflexarc_logs.container.fields import decoded
from reflexarc_logs.container.frames import (
    DATA_END_BYTES,
    FOOTER_BYTES,
    MAGIC,
    DamagedError,
    Frame,
    FrameReader,
    NotMcapError,
    NotReadHereError,
    TruncatedError,
    blocks,
    check_footer,
)
from reflexarc_logs.container.index import likely_index_in
from reflexarc_logs.container.remedy import recovery
from reflexarc_logs.container.run_info import RUN, RunInfo
from reflexarc_logs.container.writing import END, PROFILE
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.files import is_lfs_pointer
from reflexarc_runtime.words.suggestion import pasteable

MAX_METADATA_BYTES = 16 << 20
"""All that a file may say about itself, together."""
_HELD = (Opcode.HEADER, Opcode.METADATA, Opcode.DATA_END)


@dataclass
class Survey:
    """What one pass over the file found."""

    path: Path
    size: int
    profile: str = ""
    library: str = ""
    places: dict[str, Attached] = field(default_factory=dict)
    """The attachments, by name."""
    metadata: dict[str, dict[str, str]] = field(default_factory=dict)
    dropped: int = 0
    """Records and chunks that the log says are missing in its middle."""
    complete: bool = False
    intact_size: int = 0
    damage: str = ""
    """Why it is not complete."""
    is_mcap: bool = True
    is_cut: bool = False
    """Whether it only ends too early; else what is not complete is damaged."""
    refusal: str = ""
    """What in it is not read here, though the format allows it."""
    behind: int = 0
    """Bytes after the end of a log that is whole without them."""
    is_log_behind: bool = False
    held_bytes: int = 0
    data_ended: bool = False
    """Whether all messages are there, even if the index after them is damaged."""
    has_data_crc: bool = False

    @property
    def is_ours(self) -> bool:
        """Whether reflexarc recorded it, as far as it says."""
        return RUN in self.metadata or self.profile == PROFILE

    @property
    def run(self) -> RunInfo:
        """What the log says about its run.

        Raises:
            LogError: nothing, or a malformed field.
        """
        if RUN not in self.metadata:
            if self.is_cut:
                raise LogError(
                    f"{self.path}: truncated before it says of which run it is ({self.damage}); "
                    f"{recovery(self.path)} saves what is there"
                )
            raise LogError(f"{self.path}: expected {RUN} metadata, found none; not replayable")
        return RunInfo.from_metadata(self.metadata[RUN])

    @property
    def attachments(self) -> Mapping[str, bytes]:
        """The attachments, read when they are asked for."""
        return Attachments(self.path, self.places)


def survey(path: Path) -> Survey:
    """Look a log of reflexarc over.

    Raises:
        LogError: the file is missing, unreadable, empty or not MCAP; another system wrote it; it is
            damaged, or so large in a part that it is not read.
    """
    found = look(path)
    refuse(found)
    return found


def refuse(found: Survey) -> None:
    """Refuse what is no log of reflexarc, and what is damaged; one that is only cut off will do.

    Raises:
        LogError: why.
    """
    path = found.path
    if not found.is_mcap:
        raise LogError(f"{path}: expected an MCAP file, got another kind of file")
    if not found.is_ours:
        raise LogError(_foreign(found))
    if found.refusal:
        raise LogError(f"{path}: {found.refusal}")
    if found.damage and not found.is_cut:
        raise LogError(f"{path}: damaged: {found.damage}; {recovery(path)} saves the rest")


def look(path: Path) -> Survey:
    """Look any file over; what is wrong with it stands in the result.

    Raises:
        LogError: the file is missing, unreadable or empty.
    """
    found = Survey(path, _size(path))
    try:
        with path.open("rb") as file:
            check_is_no_pointer(path, file)
            _look(found, file)
    except NotMcapError:
        found.is_mcap, found.damage = False, "it does not begin as an MCAP file does"
    except TruncatedError:
        found.is_cut = True
        found.damage = f"it ends in the middle, after {found.intact_size} intact bytes"
    except NotReadHereError as error:
        found.refusal = found.damage = str(error)
    except DamagedError as error:
        found.damage = str(error)
    except OSError as error:
        raise LogError(f"{path}: cannot be read: {error.strerror}") from None
    found.complete = not found.damage
    return found


def check_is_no_pointer(path: Path, file: BinaryIO) -> None:
    """Refuse what Git LFS left in the place of a log.

    Raises:
        LogError: it is a pointer.
    """
    if is_lfs_pointer(file.read(64)):
        raise LogError(f"{path}: is a Git LFS pointer, not the log itself: `git lfs pull`")
    file.seek(0)


def is_folder(path: Path) -> bool:
    """Whether it is one; what cannot even be looked for is none."""
    try:
        return path.is_dir()
    except OSError:  # a name that is too long
        return False


def check_is_no_folder(path: Path) -> None:
    """Refuse a folder where one log is wanted.

    Raises:
        LogError: it is one.
    """
    if is_folder(path):
        joining = pasteable("reflexarc", "join", path)
        raise LogError(
            f"{path}: expected one log (.mcap), got a folder; of a recording in parts "
            f"`{joining} -o ONE.mcap` makes one"
        )


def _size(path: Path) -> int:
    check_is_no_folder(path)
    try:
        size = path.stat().st_size
    except OSError as error:
        raise LogError(f"{path}: cannot be read: {error.strerror}; give a log (.mcap)") from None
    if not size:
        raise LogError(f"{path}: expected a log, got an empty file")
    return size


def _look(found: Survey, file: BinaryIO) -> None:
    """Pass over the file from its beginning to its end."""
    reader = FrameReader(file, found.size)
    reader.magic()
    found.intact_size = reader.position
    passed = Passed()
    while True:
        crc = reader.crc
        frame = _frame(reader, file)
        if not found.data_ended:
            passed.note(frame)
        fields = _passed(found, reader, file, frame)
        if frame.opcode == Opcode.DATA_END:
            _end_data(found, frame, crc, fields)
        elif frame.opcode == Opcode.FOOTER:
            break
        elif fields:
            _note(found, decoded(frame.opcode, fields))
        found.intact_size = reader.position
    _end(found, file, reader, frame)
    if found.data_ended and not found.has_data_crc:
        _compare_with_index(found, file, passed)


def _frame(reader: FrameReader, file: BinaryIO) -> Frame:
    """The next record; where only zeros are left, a power cut ended the file before."""
    start = reader.position
    try:
        return reader.frame()
    except DamagedError:
        end = start + reader.left + (reader.position - start)
        if any(block.count(0) < len(block) for block in blocks(file, start, end)):
            raise
        raise TruncatedError from None


def _passed(found: Survey, reader: FrameReader, file: BinaryIO, frame: Frame) -> bytes:
    """Pass over a record; the fields of the few that are looked at."""
    if frame.opcode in _HELD:
        found.held_bytes += frame.size
        if found.held_bytes > MAX_METADATA_BYTES:
            raise NotReadHereError(
                f"its metadata is longer than the {MAX_METADATA_BYTES >> 20} MiB that are read"
            )
        return reader.fields(frame)
    if frame.opcode == Opcode.ATTACHMENT:
        attached = attached_at(file, frame)
        file.seek(reader.position)
        found.places.setdefault(_name_for(attached.name, found.places), attached)
    reader.read_through(frame)
    return b""


def _name_for(name: str, places: Mapping[str, Attached]) -> str:
    """The name of one more attachment: the second policy of a merged log is `policy.onnx#2`."""
    names = (nth_name(name, number) for number in range(1, MOST_OF_A_NAME + 1))
    return next((one for one in names if one not in places), name)


def _end_data(found: Survey, frame: Frame, crc: int, fields: bytes) -> None:
    if frame.size != DATA_END_BYTES:
        raise DamagedError("the end of its data is no end")
    said = decoded(frame.opcode, fields)
    expected = said.data_section_crc if isinstance(said, DataEnd) else 0
    if expected and crc != expected:
        raise DamagedError("the CRC of its data does not fit")
    found.data_ended, found.has_data_crc = True, bool(expected)


def _note(found: Survey, record: object) -> None:
    if isinstance(record, Header):
        found.profile, found.library = record.profile, record.library
    elif isinstance(record, Metadata) and record.name == END:
        _note_missing(found, record.metadata)
    elif isinstance(record, Metadata):
        found.metadata.setdefault(record.name, record.metadata)


def _note_missing(found: Survey, said: dict[str, str]) -> None:
    """What is missing is said again whenever more is; the most that was said counts."""
    known = found.metadata.setdefault(END, {})
    for name, text in said.items():
        if name not in known or _count(text) >= _count(known[name]):
            known[name] = text
    found.dropped = sum(_count(known.get(name, "0")) for name in ("dropped", "damaged_chunks"))


def _end(found: Survey, file: BinaryIO, reader: FrameReader, footer: Frame) -> None:
    """Check what stands at the end: the footer, the magic once more, and nothing behind it."""
    if footer.size != FOOTER_BYTES:
        raise DamagedError("its footer is none")
    if not found.data_ended:
        found.is_cut, found.damage = True, "its data has no end"
        return
    check_footer(file, footer)
    file.seek(reader.position)
    if reader.left < len(MAGIC):
        raise TruncatedError
    try:
        reader.magic()
    except NotMcapError:
        raise DamagedError("it does not end as an MCAP file does") from None
    found.intact_size = reader.position
    if reader.left:
        found.behind = reader.left
        found.is_log_behind = file.read(len(MAGIC)) == MAGIC
        raise DamagedError(f"there are {reader.left} bytes after its end")


def _compare_with_index(found: Survey, file: BinaryIO, passed: Passed) -> None:
    """Check the data by its index, where it has no CRC of its own."""
    index = likely_index_in(file, found.size)
    if index is not None and (why := disagreement(file, index, passed)):
        raise DamagedError(why)


def _count(text: str) -> int:
    """A count of missing records; one that cannot be read stands for at least one."""
    return int(text) if text.isascii() and text.isdigit() and len(text) < 20 else 1


def _foreign(found: Survey) -> str:
    if found.damage and not found.profile and not found.metadata:
        return (
            f"{found.path}: truncated before it says whose it is ({found.damage}); "
            f"{recovery(found.path)} saves what is there"
        )
    whose = f"profile {found.profile[:20]!r}" if found.profile else f"no {RUN} metadata"
    return (
        f"{found.path}: expected a log of reflexarc, got a log of another system ({whose}); "
        f"`{pasteable('reflexarc', 'info', found.path)}` lists its topics"
    )
