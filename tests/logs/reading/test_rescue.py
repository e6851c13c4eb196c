"""What `recover` keeps, of any system, and what it says of the rest."""

import zlib
from pathlib import Path

import lz4.frame  # type: ignore[import-untyped]  # it ships no types
import pytest
from mcap.records import (
    Attachment,
    Channel,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Message,
    MessageIndex,
    Metadata,
    Schema,
)
from mcap.stream_reader import StreamReader

from campaigns.cuts import judged, mutants, read_original
from reflexarc_logs.reading.losses import LossPlace
from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.reading.recover import Recovered, recover
from reflexarc_runtime.errors import LogError
from support.conformance_files import MAGIC, build, packed
from support.hostile_logs import chunk, end, head, message, record
from support.rewriting import flip_bit

DATA: list[McapRecord] = [
    Header("ros2", "someone"),
    Schema(1, b"\x04\x05", "ros2msg", "std_msgs/msg/String"),
    Channel(1, "/chatter", "cdr", {"offered_qos_profiles": "- history: 3"}, 1),
    Channel(7, "/schemaless", "json", {}, 0),
    Channel(8, "/chatter", "json", {}, 0),
    *(Message(n % 2 * 6 + 1, 2**64 - 1 - n, bytes([n]), 2**63 + n, n) for n in range(9)),
    Attachment(5, 2**64 - 1, "notes.txt", "text/plain", b"not ours"),
    Metadata("somebody's", {"b": "2", "a": "1"}),
]
END: list[McapRecord] = [DataEnd(0), Footer(0, 0, 1875167664)]


def data_of(path: Path) -> list[McapRecord]:
    with path.open("rb") as file:
        records = StreamReader(file, validate_crcs=True).records
        until = iter(lambda: next(records), DataEnd(0))
        taken: list[McapRecord] = []
        for each in until:
            if isinstance(each, DataEnd):
                break
            taken.append(each)
    return [each for each in taken if not isinstance(each, MessageIndex)]


def recovered(folder: Path, data: bytes) -> Recovered:
    (folder / "broken.mcap").write_bytes(data)
    return recover(folder / "broken.mcap", folder / "saved.mcap")


@pytest.mark.parametrize("features", [{"pad"}, {"ch", "mx", "pad"}, {"ch"}, set()])
def test_every_record_of_another_system_is_kept(features: set[str], tmp_path: Path):
    saved = recovered(tmp_path, build([*DATA, *END], frozenset(features)))
    wanted = [r for r in DATA if not (isinstance(r, Attachment | Metadata) and "ch" in features)]
    got = data_of(saved.path)
    assert [r for r in got if r in wanted] == wanted
    assert len(got) == len(DATA)
    assert (saved.exit_status, saved.is_ours, saved.messages) == (0, False, 9)


def test_a_record_that_the_format_does_not_know_is_kept(tmp_path: Path):
    private = record(0x90, b"private")
    saved = recovered(tmp_path, end(head() + message() + private))
    assert private in saved.path.read_bytes()


def test_faults_anywhere_lose_nothing_intact_and_invent_nothing(log_path: Path, tmp_path: Path):
    original = read_original(log_path)
    for mutant in mutants(original.data, 40, 120, seed=7):
        assert judged(original, mutant, tmp_path)[0] == "", mutant.name


def test_a_lost_beginning_is_said_and_the_rest_is_saved(log_path: Path, tmp_path: Path):
    whole = list(read_log(log_path).records())
    start = read_original(log_path).parts[-40][0] - 100
    saved = recovered(tmp_path, log_path.read_bytes()[start:])
    assert saved.losses[0].place is LossPlace.BEGINNING
    assert 0 < saved.messages < len(whole)
    assert saved.exit_status == 1
    topics = {r.topic for r in data_of(saved.path) if isinstance(r, Channel)}
    assert "/robot0/tick" in topics  # the index at the end names channels whose records are lost
    assert not any(topic.startswith("/recovered/") for topic in topics)


def test_messages_whose_channel_is_lost_keep_their_place_under_a_made_up_name(tmp_path: Path):
    content = message(3, b"kept") * 2
    saved = recovered(tmp_path, end(MAGIC + record(1, bytes(8)) + chunk(content, content, b"")))
    (channel,) = [r for r in data_of(saved.path) if isinstance(r, Channel)]
    assert (channel.topic, channel.schema_id) == ("/recovered/channel-3", 0)
    assert (saved.messages, saved.nameless_channels, saved.exit_status) == (2, 1, 1)


def test_a_log_behind_the_end_is_counted(log_path: Path, tmp_path: Path):
    data = log_path.read_bytes()
    (loss,) = recovered(tmp_path, data + data).losses
    assert (loss.place, loss.bytes) == (LossPlace.BEHIND, len(data))
    assert "another log" in loss.what


def test_a_log_that_holds_no_message_never_ends_with_status_0(tmp_path: Path):
    content = message()
    unread = chunk(content, b"BZh", b"bz2")
    saved = recovered(tmp_path, end(head() + unread))
    assert (saved.messages, saved.exit_status) == (0, 1)
    assert "'bz2', which is not read here" in saved.losses[0].what


def test_nothing_to_save_writes_nothing(tmp_path: Path):
    for data in (b"hello" * 20, MAGIC, MAGIC + b"\xff" * 99):
        with pytest.raises(LogError, match=r"nothing to save|another kind of file"):
            recovered(tmp_path, data)
        assert not (tmp_path / "saved.mcap").exists()


def test_an_attachment_that_changed_is_left_out_and_named(tmp_path: Path):
    data = build([*DATA, *END], frozenset())
    saved = recovered(tmp_path, flip_bit(data, data.index(b"not ours")))
    assert not any(isinstance(r, Attachment) for r in data_of(saved.path))
    assert "an attachment" in saved.losses[0].what
    assert (saved.messages, saved.exit_status) == (9, 1)


def test_damage_outside_of_all_chunks_is_a_doubt(tmp_path: Path):
    data = end(head() + message())
    saved = recovered(tmp_path, flip_bit(data, data.index(b"run_id")))
    assert "the CRC of its data does not fit" in saved.doubt
    assert saved.exit_status == 1


def test_chunks_of_lz4_are_read_and_copied_as_they_are(tmp_path: Path):
    content = message(1, b"x") * 50
    packed_content = bytes(lz4.frame.compress(content))
    data = end(head() + chunk(content, packed_content, b"lz4"))
    saved = recovered(tmp_path, data)
    assert (saved.messages, saved.exit_status) == (50, 0)
    assert packed_content in saved.path.read_bytes()
    assert sum(1 for _ in read_log(saved.path).records()) == 50


def test_the_crc_of_a_footer_without_an_index_covers_its_own_offsets():
    """The figure of the format's own conformance suite; by hand: the first 25 bytes."""
    footer = packed(Footer(0, 0, 0))[:25]
    assert zlib.crc32(footer) == 1875167664


def test_a_file_of_another_system_is_never_called_damaged(tmp_path: Path):
    path = tmp_path / "other.mcap"
    for data in (build([*DATA, *END], frozenset()), build([*DATA, *END], frozenset())[:-30]):
        path.write_bytes(data)
        with pytest.raises(LogError, match="a log of another system") as caught:
            read_log(path)
        assert "damaged" not in str(caught.value)
