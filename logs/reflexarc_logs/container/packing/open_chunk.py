"""The chunk that messages are put into, until it is compressed and written."""

import struct
import zlib
from array import array

from mcap.opcode import Opcode

from reflexarc_logs.container.fields import MESSAGE
from reflexarc_logs.container.frames import HEAD
from reflexarc_logs.container.packing.compression import ZSTD, Compressor
from reflexarc_logs.container.raw_log import ChunkContent

_MESSAGE = struct.Struct(HEAD.format + MESSAGE.format.lstrip("<"))
"""Kind and length of a message, and its fields up to its payload."""
_CHUNK = struct.Struct("<QQQI")
"""First and last log time, bytes before compression and their CRC; the compression's name and the
compressed bytes follow."""


class OpenChunk:
    """Schemas, channels and messages in the order in which they came."""

    def __init__(self) -> None:
        self._records = bytearray()
        self._entries: dict[int, array[int]] = {}

    @property
    def size_bytes(self) -> int:
        """What it holds, uncompressed."""
        return len(self._records)

    @property
    def has_messages(self) -> bool:
        """Whether it holds more than schemas and channels."""
        return bool(self._entries)

    def define(self, opcode: int, fields: bytes) -> None:
        """Put in a schema or a channel."""
        self._records += HEAD.pack(opcode, len(fields)) + fields

    def message(
        self, channel: int, payload: bytes, *, sequence: int, publish_ns: int, log_ns: int
    ) -> None:
        """Put in a message; times in nanoseconds, not negative."""
        size = MESSAGE.size + len(payload)
        head = _MESSAGE.pack(Opcode.MESSAGE, size, channel, sequence, log_ns, publish_ns)
        entries = self._entries.setdefault(channel, array("Q"))
        entries.extend((log_ns, len(self._records)))
        self._records += head
        self._records += payload

    def taken(self, compressor: Compressor) -> tuple[bytes, ChunkContent]:
        """The fields of its record, and what its index needs; it is empty then."""
        records, entries = bytes(self._records), self._entries
        compressed = compressor.compress(records)
        content = ChunkContent(ZSTD, len(compressed), len(records), entries)
        head = _CHUNK.pack(content.first_ns, content.last_ns, len(records), zlib.crc32(records))
        name = struct.pack("<I", len(ZSTD)) + ZSTD.encode()
        self._records, self._entries = bytearray(), {}
        return head + name + struct.pack("<Q", len(compressed)) + compressed, content
