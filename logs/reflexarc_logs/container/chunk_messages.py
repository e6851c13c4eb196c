"""The messages in a chunk that was unpacked, without an object for each field.

The MCAP library's own walk makes some thirty calls for each message; where millions are only passed
on or compared as bytes, that is most of the time.
"""

import struct
from collections.abc import Iterator
from io import BytesIO
from typing import NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Schema

from reflexarc_logs.container.record_stream import DamagedError

_RECORD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<HIQQ")


class ChunkMessage(NamedTuple):
    """One message; times in nanoseconds."""

    channel_id: int
    sequence: int
    log_ns: int
    publish_ns: int
    payload: bytes


def walk(data: bytes) -> Iterator[ChunkMessage | Schema | Channel]:
    """What stands in a chunk, in its order.

    Args:
        data: the chunk's content, unpacked and checked.

    Raises:
        DamagedError: a record reaches beyond the end, or is shorter than its own fields.
    """
    at, end = 0, len(data)
    try:
        while at < end:
            opcode, length = _RECORD.unpack_from(data, at)
            at, start = at + _RECORD.size + length, at + _RECORD.size
            if at > end:
                raise DamagedError("a chunk: a record reaches beyond its end")
            if opcode == Opcode.MESSAGE:
                fields = _MESSAGE.unpack_from(data, start)
                yield ChunkMessage._make((*fields, data[start + _MESSAGE.size : at]))
            elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
                kind = Schema if opcode == Opcode.SCHEMA else Channel
                yield kind.read(ReadDataStream(BytesIO(data[start:at])))
    except (struct.error, ValueError) as error:
        raise DamagedError(f"a chunk: {error}") from None
