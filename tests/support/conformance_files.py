"""Files of the MCAP conformance suite, built from the JSON that describes each of them.

The suite (foxglove/mcap, tests/conformance/data, MIT) keeps its files as Git LFS pointers, whose
SHA-256 tells whether a file that was built here is the suite's, byte for byte.
"""

import hashlib
import json
import zlib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from mcap import records as mcap_records
from mcap.data_stream import RecordBuilder
from mcap.records import Channel, Chunk, DataEnd, McapRecord, Message, MessageIndex, Schema

MAGIC = b"\x89MCAP0\r\n"
PAD = b"\x01\xff\xff"
"""What the suite adds to records, as a later version of the format might."""
_CHUNKED = (Schema, Channel, Message)
_UNPADDED = ("Message", "DataEnd", "Footer", "Chunk")
_TEXTS = ("library", "profile", "encoding", "name", "topic", "message_encoding", "media_type")


def records_of(path: Path) -> tuple[list[McapRecord], frozenset[str]]:
    """The records that a JSON of the suite lists, and the features of the file."""
    document = json.loads(path.read_text())
    records = [_record(entry) for entry in document["records"]]
    return records, frozenset(document["meta"]["variant"]["features"])


def build(records: list[McapRecord], features: frozenset[str]) -> bytes:
    """The bytes of the file that these records describe."""
    is_padded = "pad" in features
    end = next(i for i, record in enumerate(records) if isinstance(record, DataEnd))
    in_chunk = [r for r in records[:end] if "ch" in features and isinstance(r, _CHUNKED)]
    parts = [packed(r, is_padded) for r in records[:end] if r not in in_chunk]
    if "ch" in features:
        parts += _chunk(in_chunk, "mx" in features, is_padded)
    parts += [packed(record, is_padded) for record in records[end:]]
    return b"".join([MAGIC, *parts, MAGIC])


def is_the_suites(data: bytes, pointer: Path) -> bool:
    """Whether these bytes are those of which the suite keeps this pointer."""
    wanted = f"oid sha256:{hashlib.sha256(data).hexdigest()}"
    return wanted in pointer.read_text(errors="replace")


def packed(record: McapRecord, is_padded: bool = False) -> bytes:
    """A record as bytes."""
    builder = RecordBuilder()
    record.write(builder)
    data = bytes(builder.end())  # type: ignore[no-untyped-call]  # mcap has no type for it
    if not is_padded or type(record).__name__ in _UNPADDED:
        return data
    size = len(data) - 9 + len(PAD)
    return data[:1] + size.to_bytes(8, "little") + data[9:] + PAD


def _chunk(records: Iterable[McapRecord], indexed: bool, is_padded: bool) -> Iterator[bytes]:
    """A chunk without compression, and its indexes."""
    content, indexes, times = b"", dict[int, list[tuple[int, int]]](), list[int]()
    for record in records:
        if isinstance(record, Channel):
            indexes.setdefault(record.id, [])
        elif isinstance(record, Message):
            indexes.setdefault(record.channel_id, []).append((record.log_time, len(content)))
            times.append(record.log_time)
        content += packed(record)
    first_ns, last_ns = min(times, default=0), max(times, default=0)
    yield packed(Chunk("", content, last_ns, first_ns, zlib.crc32(content), len(content)))
    if indexed:
        for channel, entries in indexes.items():
            yield packed(MessageIndex(channel, entries), is_padded)


def _record(entry: dict[str, Any]) -> McapRecord:
    fields = {name: _value(name, value) for name, value in entry["fields"]}
    record: McapRecord = getattr(mcap_records, entry["type"])(**fields)
    return record


def _value(name: str, value: Any) -> Any:
    if name == "data":
        return bytes(map(int, value))
    if name == "metadata":
        return value
    if isinstance(value, dict):
        return {int(key): int(number) for key, number in value.items()}
    return value if name in _TEXTS or name == "compression" else int(value)
