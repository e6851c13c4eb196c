"""Logs that were made to harm: bombs, forged lengths, endless lists; each begins as ours do."""

import os
import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import lz4.frame  # type: ignore[import-untyped]  # it ships no types
import zstandard

MAGIC = b"\x89MCAP0\r\n"
MIB = 1 << 20


def record(opcode: int, body: bytes, length: int | None = None) -> bytes:
    """A record, its length as it is or as it is claimed to be."""
    return struct.pack("<BQ", opcode, len(body) if length is None else length) + body


def text(words: bytes) -> bytes:
    """A string of the format."""
    return struct.pack("<I", len(words)) + words


def head() -> bytes:
    """What the file of a run of ours begins with."""
    pair = text(b"run_id") + text(b"ab")
    named = text(b"reflexarc.run") + struct.pack("<I", len(pair)) + pair
    return MAGIC + record(1, text(b"reflexarc") + text(b"")) + record(12, named) + channel()


def channel(number: int = 1, topic: bytes = b"/robot0/tick") -> bytes:
    """A channel without a schema."""
    return record(4, struct.pack("<HH", number, 0) + text(topic) + text(b"") + bytes(4))


def message(number: int = 1, payload: bytes = b"") -> bytes:
    """A message at time 0."""
    return record(5, struct.pack("<HIQQ", number, 0, 0, 0) + payload)


def chunk(content: bytes, packed: bytes, compression: bytes, claimed: int | None = None) -> bytes:
    """A chunk whose CRC fits."""
    size = len(content) if claimed is None else claimed
    fields = struct.pack("<QQQI", 0, 0, size, zlib.crc32(content)) + text(compression)
    return record(6, fields + struct.pack("<Q", len(packed)) + packed)


def end(data: bytes, summary: bytes = b"") -> bytes:
    """The file with its end; its CRCs fit."""
    data += record(15, struct.pack("<I", zlib.crc32(data)))
    footer = struct.pack("<BQQQ", 2, 20, len(data) if summary else 0, 0)
    return data + summary + footer + struct.pack("<I", zlib.crc32(summary + footer)) + MAGIC


def _bomb(content: bytes, times: int, *, sized: bool = True) -> bytes:
    packed = zstandard.ZstdCompressor(write_content_size=sized).compress(content)
    return end(head() + chunk(content, packed, b"zstd") * times)


def _lz4_bomb() -> bytes:
    content = message() * (32 * MIB // 31)
    return end(head() + chunk(content, bytes(lz4.frame.compress(content)), b"lz4") * 40)


def _lying_chunk(claimed: int) -> bytes:
    content = bytes(200 * MIB)
    packed = zstandard.ZstdCompressor(write_content_size=False).compress(content)
    return end(head() + chunk(content, packed, b"zstd", claimed))


def _forged_index() -> bytes:
    content = message() * 3
    offsets = struct.pack("<IHQ", 10, 1, 2**63)
    place = struct.pack("<QQQQ", 0, 2**64 - 1, 2**62, 2**62) + offsets
    place += struct.pack("<Q", 2**62) + text(b"") + struct.pack("<QQ", 2**62, 2**62)
    counts = struct.pack("<QHIIIIQQIHQ", 2**60, 0, 1, 0, 0, 1, 0, 2**64 - 1, 10, 1, 2**60)
    data = head() + chunk(content, content, b"") + record(9, _attachment(b"x", 5 * MIB))
    return end(data, channel() + record(11, counts) + record(8, place))


def _attachment(name: bytes, size: int) -> bytes:
    fields = bytes(16) + text(name) + text(b"") + struct.pack("<Q", size) + bytes(size)
    return fields + struct.pack("<I", zlib.crc32(fields))


def _many_channels() -> bytes:
    return head() + b"".join(channel(n, b"/%d" % n * 40) for n in range(2**16)) + message(7)


def _plausible(piece: bytes, size: int) -> bytes:
    """A file whose chain breaks at once, and whose every byte looks like a beginning."""
    return head() + b"\x00" * 9 + b"\xff" + piece * (size // len(piece))


_MESSAGES = message() * (MIB // 31)
BYTES: dict[str, Callable[[], bytes]] = {
    "zstd: 1,000 chunks of 32 MiB of zeros": lambda: _bomb(bytes(32 * MIB), 1000),
    "zstd: 1,000 chunks of a million messages": lambda: _bomb(_MESSAGES * 30, 1000),
    "zstd: the same, its frames hide their size": lambda: _bomb(_MESSAGES, 3000, sized=False),
    "lz4: 40 chunks of a million messages": _lz4_bomb,
    "a chunk of 200 MiB that says 10 bytes": lambda: _lying_chunk(10),
    "a chunk that says 2^63 bytes": lambda: _lying_chunk(2**63),
    "a record of 2^63 bytes": lambda: head() + record(5, b"x" * 99, 2**63),
    "a message shorter than its fields": lambda: end(head() + record(5, b"", 3) + b"abc"),
    "metadata whose text is 4 GiB long": lambda: end(head() + record(12, b"\xff" * 99)),
    "an attachment that claims 2^60 bytes": lambda: end(
        head() + record(9, bytes(16) + text(b"policy.onnx") + text(b"") + struct.pack("<Q", 2**60))
    ),
    "an index that points beyond the file": _forged_index,
    "65,536 channels, cut off": _many_channels,
    "a broken chain, then 24 MB of heads of chunks": lambda: _plausible(
        record(6, bytes(28) + text(b"zstd") + struct.pack("<Q", 0)), 24 * MIB
    ),
    "a broken chain, then 24 MB of heads of metadata": lambda: _plausible(
        record(12, text(b"") + bytes(4)) + b"\xff" * 3, 24 * MIB
    ),
}
"""By name: what makes the bytes of a file."""


def policy_of_300_mib(path: Path) -> None:
    """A log whose attached policy is 300 MiB of zeros, in a file with a hole."""
    size = 300 * MIB
    fields = bytes(16) + text(b"policy.onnx") + text(b"") + struct.pack("<Q", size)
    with path.open("wb") as file:
        file.write(head() + struct.pack("<BQ", 9, len(fields) + size + 4) + fields)
        file.seek(size, os.SEEK_CUR)
        file.write(bytes(4) + record(15, bytes(4)) + record(2, bytes(20)) + MAGIC)


def zeros_after_a_power_cut(path: Path) -> None:
    """A log that ends in 2 GiB of zeros, in a file with a hole."""
    with path.open("wb") as file:
        file.write(head() + message())
        file.truncate(2048 * MIB)


FILES: dict[str, Callable[[Path], None]] = {
    "a policy of 300 MiB": policy_of_300_mib,
    "2 GiB of zeros after a power cut": zeros_after_a_power_cut,
}
"""By name: what writes a file that is too large for memory."""
