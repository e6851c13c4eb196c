"""Channels whose own record is lost: looked for in the rest of the file, else given a stand-in."""

from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Schema

from reflexarc_logs.container.chunks import Allowance, content_of, records_in
from reflexarc_logs.container.fields import decoded
from reflexarc_logs.container.file_bytes import FileBytes
from reflexarc_logs.container.frames import HEAD, DamagedError, Frame, NotReadHereError
from reflexarc_logs.container.index import index_in
from reflexarc_logs.container.raw_log import bytes_of
from reflexarc_logs.salvaging.salvage import Salvage, fields_of

NAMELESS = "reflexarc.recovered"
"""Metadata of a channel that `recover` made up, because messages need one."""
_WANTED = (Opcode.SCHEMA, Opcode.CHANNEL)


def stand_in(number: int) -> tuple[Channel, bytes]:
    """A channel for messages of which nothing is known but its number."""
    why = {NAMELESS: "the record of this channel is lost"}
    channel = Channel(number, f"/recovered/channel-{number}", "", why, 0)
    return channel, bytes_of(channel)[HEAD.size :]


def nameless_schema(number: int) -> bytes:
    """The fields of a schema of which nothing is known but its number."""
    return bytes_of(Schema(number, b"", "", f"recovered/Schema{number}"))[HEAD.size :]


def defined_later(data: FileBytes) -> dict[tuple[int, int], bytes]:
    """The fields of every schema and channel in a file, by kind and number; the first counts."""
    found: dict[tuple[int, int], bytes] = {}
    allowance = Allowance.of(data.size)
    salvage = Salvage(data, is_whole=False, index=None)
    for frame in salvage.walk():
        if isinstance(frame, Frame):
            try:
                _collect(found, data, frame, allowance)
            except (DamagedError, NotReadHereError):
                continue
    index = index_in(data.file, data.size, salvage.end)
    return found if index is None else {**index.raw, **found}


def _collect(
    found: dict[tuple[int, int], bytes], data: FileBytes, frame: Frame, allowance: Allowance
) -> None:
    if frame.opcode in _WANTED:
        _note(found, frame.opcode, fields_of(data, frame))
    elif frame.opcode == Opcode.CHUNK:
        chunk = decoded(Opcode.CHUNK, fields_of(data, frame))
        if isinstance(chunk, Chunk):
            content = content_of(chunk, allowance)
            for opcode, start, end in records_in(content, allowance):
                if opcode in _WANTED:
                    _note(found, opcode, content[start:end])


def _note(found: dict[tuple[int, int], bytes], opcode: int, fields: bytes) -> None:
    record = decoded(opcode, fields)
    if isinstance(record, Schema | Channel):
        found.setdefault((opcode, record.id), fields)
