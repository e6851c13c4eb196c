"""Small logs of every layout, and which of their bytes hold an MCAP file together.

Framing is what no payload is: each record's kind and length, the fields of a chunk in front of its
data, message indexes, the summary, names and lengths of attachments and metadata. The walk here is
its own, over the bytes of a whole file; nothing of the product is in it.
"""

import struct
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

from mcap.writer import CompressionType, Writer

from reflexarc_logs.container.writing import LogWriter

MAGIC = b"\x89MCAP0\r\n"
_SCHEMA, _MESSAGE, _CHUNK, _ATTACHMENT, _METADATA = 3, 5, 6, 9, 12
_HEAD_BYTES, _MESSAGE_BYTES = 9, 22
_MOST_OF_A_RECORD = 160
"""So much of the beginning of other records is framing, and a tenth of it of their end."""


class Piece(NamedTuple):
    """A record of a whole file, or one of its two magics."""

    kind: int
    """0: a magic."""
    start: int
    end: int


def pieces(data: bytes) -> Iterator[Piece]:
    """All that a whole file is made of, in its order."""
    yield Piece(0, 0, len(MAGIC))
    at = len(MAGIC)
    while at < len(data) - len(MAGIC):
        kind, size = struct.unpack_from("<BQ", data, at)
        yield Piece(kind, at, at + _HEAD_BYTES + size)
        at += _HEAD_BYTES + size
    yield Piece(0, at, len(data))


def framing(data: bytes, piece: Piece) -> Iterator[int]:
    """Offsets of the bytes of a record that are framing."""
    start, end = piece.start + _HEAD_BYTES, piece.end
    yield from range(piece.start, min(start, end))
    if piece.kind == _CHUNK:
        yield from range(start, start + _chunk_fields(data, start))
    elif piece.kind == _MESSAGE:
        yield from range(start, start + _MESSAGE_BYTES)
    elif piece.kind == _ATTACHMENT:
        (name,) = struct.unpack_from("<I", data, start + 16)
        (kind,) = struct.unpack_from("<I", data, start + 20 + name)
        yield from range(start, start + 32 + name + kind)
        yield from range(end - 4, end)
    else:
        first = min(end, start + _MOST_OF_A_RECORD)
        yield from range(start, first)
        yield from range(max(first, end - _MOST_OF_A_RECORD // 10), end)


def _chunk_fields(data: bytes, start: int) -> int:
    """Bytes in front of a chunk's data: times, size, CRC, compression, length."""
    (compression,) = struct.unpack_from("<I", data, start + 28)
    return 40 + int(compression)


def ours(path: Path) -> None:
    """As the recorder writes, in small chunks."""
    writer = LogWriter(path, chunk_bytes=300)
    writer.attach("policy.onnx", "application/onnx", bytes(range(200)))
    writer.attach("config.json", "application/json", b"{}")
    writer.describe("reflexarc.run", {"run_id": "5eed", "robot": "robot0"})
    channels = [writer.raw_channel(f"/topic{n}", "json", None, {"of": str(n)}) for n in range(3)]
    for number in range(24):
        at_ns = 1_700_000_000_000_000_000 + number * 10_000_000
        payload = bytes(range(number, number * 4 + 20))
        writer.add(
            channels[number % 3], payload, sequence=number, publish_ns=at_ns + 5, log_ns=at_ns
        )
    writer.finish()


def by_defaults(path: Path) -> None:
    """As the MCAP library writes when it is told nothing: no CRC over the data."""
    _written(path, chunk_size=400)


def with_attachments_between(path: Path) -> None:
    """Chunks of no compression, with attachments and metadata between them."""
    _written(
        path, between=True, chunk_size=400, compression=CompressionType.NONE, enable_data_crcs=True
    )


def unchunked(path: Path) -> None:
    """No chunks: every message stands for itself."""
    _written(path, between=True, use_chunking=False, enable_data_crcs=True)


def unchunked_without_checks(path: Path) -> None:
    """No chunks and no CRC of any kind, all messages of one length that is a power of two."""
    _written(path, use_chunking=False, enable_crcs=False, payload_bytes=33)


LAYOUTS: dict[str, Callable[[Path], None]] = {
    "ours": ours,
    "defaults": by_defaults,
    "attachments": with_attachments_between,
    "unchunked": unchunked,
    "unchecked": unchunked_without_checks,
}
"""By name: what writes a small log of 24 messages."""


def _written(
    path: Path,
    *,
    between: bool = False,
    payload_bytes: int = 0,
    chunk_size: int = 1 << 20,
    compression: CompressionType = CompressionType.ZSTD,
    **how: bool,
) -> None:
    with path.open("wb") as out:
        writer = Writer(out, chunk_size=chunk_size, compression=compression, **how)
        writer.start(profile="", library="another tool")
        channels = [_channel(writer, number) for number in range(3)]
        for number in range(24):
            at_ns = 1_700_000_000_000_000_000 + number * 10_000_000
            payload = bytes(range(number, number + (payload_bytes or 20 + number * 3)))
            writer.add_message(channels[number % 3], at_ns, payload, at_ns + 5, number)
            if between and number % 8 == 3:
                writer.add_attachment(at_ns, at_ns, f"note{number}.txt", "text/plain", payload)
                writer.add_metadata(f"note{number}", {"number": str(number), "of": "24"})
        writer.finish()


def _channel(writer: Writer, number: int) -> int:
    schema = writer.register_schema(f"demo/Kind{number}", "jsonschema", b'{"type": "object"}')
    return writer.register_channel(f"/topic{number}", "json", schema, {"place": str(number)})
