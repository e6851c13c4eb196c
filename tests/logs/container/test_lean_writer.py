"""The lean writer against the mcap library's own."""

import io
import random
from concurrent.futures import ThreadPoolExecutor

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from reflexarc_logs.lean_writer import LeanWriter

CHUNK_BYTES = 2000
TIMES = st.integers(0, 2**63)
MESSAGES = st.lists(
    st.tuples(st.integers(1, 3), TIMES, st.binary(max_size=900), TIMES, st.integers(0, 2**32 - 1)),
    min_size=1,
    max_size=40,
)
Message = tuple[int, int, bytes, int, int]


def written(writer: Writer | LeanWriter, messages: list[Message]) -> None:
    writer.start(profile="test")
    writer.add_metadata("run", {"robot": "robot0"})
    writer.add_attachment(3, 4, "config.json", "application/json", b"{}")
    schemas = [writer.register_schema(name, "protobuf", b"descriptors") for name in "AB"]
    for topic, schema in zip(("/a", "/b", "/c"), (*schemas, schemas[0]), strict=True):
        writer.register_channel(topic, "protobuf", schema)
    for message in messages:
        writer.add_message(*message)
    writer.finish()  # type: ignore[no-untyped-call]  # mcap has no type for it


def lean(messages: list[Message]) -> bytes:
    file = io.BytesIO()
    with ThreadPoolExecutor(max_workers=1) as beside:
        written(LeanWriter(file, beside, CHUNK_BYTES), messages)
    return file.getvalue()


@given(MESSAGES)
def test_the_file_is_the_very_file_of_the_library(messages: list[Message]):
    file = io.BytesIO()
    options = {"chunk_size": CHUNK_BYTES, "enable_crcs": True, "enable_data_crcs": True}
    written(Writer(file, compression=CompressionType.ZSTD, **options), messages)  # type: ignore[arg-type]  # bool and int
    assert lean(messages) == file.getvalue()


def test_the_library_finds_every_message_by_its_index_and_checks_it():
    messages = [(k % 3 + 1, 100 * k, bytes(300), k, k) for k in range(50)]
    reader = make_reader(io.BytesIO(lean(messages)), validate_crcs=True)
    found = [
        (m.channel_id, m.log_time, m.data, m.publish_time, m.sequence)
        for _, _, m in reader.iter_messages()
    ]
    assert found == messages
    only = [
        m.log_time for _, _, m in reader.iter_messages("/b", starting_at=1000, ending_before=2000)
    ]
    assert only == [100 * k for k in range(10, 20) if k % 3 == 1]


def test_what_fails_while_it_is_written_is_raised_to_the_caller():
    class Full(io.BytesIO):
        def write(self, data: object) -> int:
            if self.tell() > CHUNK_BYTES:
                raise OSError(28, "No space left on device")
            return super().write(data)  # type: ignore[arg-type]  # bytes

    messages = [(1, k, random.Random(k).randbytes(900), k, k) for k in range(20)]
    with ThreadPoolExecutor(max_workers=1) as beside:
        writer = LeanWriter(Full(), beside, CHUNK_BYTES)
        with pytest.raises(OSError, match="No space"):
            written(writer, messages)
