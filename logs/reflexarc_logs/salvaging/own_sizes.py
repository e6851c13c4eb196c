"""How long a record is by its own fields, whatever its head says of its length."""

import struct

from mcap.opcode import Opcode

from reflexarc_logs.container.attachments import MAX_NAME_BYTES
from reflexarc_logs.container.fields import is_measurable, read_fields
from reflexarc_logs.container.file_bytes import FileBytes
from reflexarc_logs.container.frames import (
    CRC_BYTES,
    DATA_END_BYTES,
    FOOTER_BYTES,
    HEAD,
    DamagedError,
)

_FIXED = {Opcode.DATA_END: DATA_END_BYTES, Opcode.FOOTER: FOOTER_BYTES}
_TIMES_BYTES = 16
_CHUNK_NUMBERS_BYTES = 28
"""Two times, a size and a CRC, in front of the name of the compression."""
_MOST_OF_A_COMPRESSION = 64
_INDEX_HEAD = struct.Struct("<HI")
"""Channel of a message index, and the length of its entries."""
_INDEX_ENTRY_BYTES = 16


def is_measured(opcode: int) -> bool:
    """Whether the fields of such a record say where they end; a message's do not."""
    return opcode in _FIXED or opcode == Opcode.ATTACHMENT or is_measurable(opcode)


def own_size(data: FileBytes, opcode: int, start: int) -> int | None:
    """Bytes of the fields of the record that begins here, taken for one of this kind.

    None: they make no sense. The file may end before they do.
    """
    body = start + HEAD.size
    match opcode:
        case Opcode.DATA_END | Opcode.FOOTER:
            return _FIXED[Opcode(opcode)]
        case Opcode.MESSAGE_INDEX:
            return _of_message_index(data, body)
        case Opcode.CHUNK:
            return _of_chunk(data, body)
        case Opcode.ATTACHMENT:
            return _of_attachment(data, body)
    if not is_measurable(opcode):
        return None
    try:
        return read_fields(opcode, data.source(body))[1]
    except (DamagedError, MemoryError):
        return None


def _of_message_index(data: FileBytes, body: int) -> int | None:
    head = data.at(body, _INDEX_HEAD.size)
    if len(head) < _INDEX_HEAD.size:
        return None
    length = int(_INDEX_HEAD.unpack(head)[1])
    return None if length % _INDEX_ENTRY_BYTES else _INDEX_HEAD.size + length


def _of_chunk(data: FileBytes, body: int) -> int | None:
    name = _text_end(data, body + _CHUNK_NUMBERS_BYTES, _MOST_OF_A_COMPRESSION)
    length = None if name is None else _number(data, name, 8)
    return None if name is None or length is None else name + 8 + length - body


def _of_attachment(data: FileBytes, body: int) -> int | None:
    name = _text_end(data, body + _TIMES_BYTES, MAX_NAME_BYTES)
    media = None if name is None else _text_end(data, name, MAX_NAME_BYTES)
    length = None if media is None else _number(data, media, 8)
    return None if media is None or length is None else media + 8 + length + CRC_BYTES - body


def _text_end(data: FileBytes, at: int, most: int) -> int | None:
    """Where a text ends that begins with its length; None: it has no end."""
    length = _number(data, at, 4)
    return None if length is None or length > most else at + 4 + length


def _number(data: FileBytes, at: int, size: int) -> int | None:
    taken = data.at(at, size)
    return int.from_bytes(taken, "little") if len(taken) == size else None
