"""Bombs and forged lengths are refused before they are unpacked; the campaign measures the rest."""

from pathlib import Path

import pytest

from reflexarc_logs.container.chunks import Allowance
from reflexarc_logs.container.frames import NotReadHereError
from reflexarc_logs.reading.recover import recover
from reflexarc_logs.reading.summary import describe_any
from reflexarc_runtime.errors import LogError
from support import hostile_logs

QUICK = [
    "a chunk that says 2^63 bytes",
    "a record of 2^63 bytes",
    "a message shorter than its fields",
    "metadata whose text is 4 GiB long",
    "an attachment that claims 2^60 bytes",
    "an index that points beyond the file",
]


@pytest.mark.parametrize("name", QUICK)
def test_a_hostile_log_is_one_error_of_the_log_or_is_read(name: str, tmp_path: Path):
    path = tmp_path / "hostile.mcap"
    path.write_bytes(hostile_logs.BYTES[name]())
    try:
        describe_any(path)
    except LogError as error:
        complaint = str(error)
        assert "\n" not in complaint  # it may as well be read
    assert recover(path, tmp_path / "saved.mcap").messages <= 3


def test_what_all_chunks_unpack_to_is_bounded_by_the_size_of_the_file():
    allowance = Allowance.of(10_000)
    allowance.take_bytes(1 << 30)
    allowance.take_bytes(1_000_000)
    with pytest.raises(NotReadHereError, match="over 100 times"):
        allowance.take_bytes(1)
    allowance.take_records(501_250)
    with pytest.raises(NotReadHereError, match="a record for every 8 bytes"):
        allowance.take_records(1)
