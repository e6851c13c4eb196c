"""Who sent a message is in the log, however many there are."""

from dataclasses import replace

import pytest
from mcap.reader import make_reader

from reflexarc_logs.container.rejected import KEPT_BYTES, MAX_SENDERS
from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.reading.recover import recover
from reflexarc_logs.reading.summary import summarise
from reflexarc_logs.replaying.loop_events import loop_events
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.messages.wire import (
    Message,
    Stamp,
    lockstep_sender,
    pack_stamp,
    unpack_stamp,
)
from support.policies import exported
from support.recordings import CONTRACT, drive, nominal

TICKS = 60


def identity(number: int) -> bytes:
    return number.to_bytes(16, "little")


def from_many(count: int) -> dict[int, list[Message]]:
    """One retina a slot, each from the next of `count` senders."""

    def sent_by(message: Message, sender: bytes) -> Message:
        stamp = replace(unpack_stamp(message.attachment), sender=sender)
        return replace(message, attachment=pack_stamp(stamp))

    schedule = nominal(TICKS)
    return {
        slot: [sent_by(m, identity(1 + slot % count)) for m in batch]
        for slot, batch in schedule.items()
    }


@pytest.fixture(scope="module")
def policy() -> bytes:
    return exported(CONTRACT, 3, "Relu")


@pytest.mark.parametrize("count", [1, 3, MAX_SENDERS])
def test_each_sender_has_a_channel_that_names_it(count, policy, tmp_path):
    drive(tmp_path / "log.mcap", policy, from_many(count), TICKS)
    log = read_log(tmp_path / "log.mcap")
    senders = [record.sender for record in log.records("/robot0/retina")]
    assert senders == [identity(1 + slot % count) for slot in range(1, TICKS + 1)]
    assert replay(log).exit_status == 0
    with log.path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    channels = [c for c in summary.channels.values() if c.topic == "/robot0/retina"]
    names = {c.metadata["reflexarc.sender"] for c in channels}
    assert names == {identity(1 + number).hex() for number in range(count)}
    assert {t.topic: t.messages for t in summarise(log).topics}["/robot0/retina"] == TICKS


def test_a_crowd_is_kept_on_the_rejected_channel_and_replays(policy, tmp_path):
    schedule = from_many(3 * MAX_SENDERS)
    drive(tmp_path / "log.mcap", policy, schedule, TICKS)
    log = read_log(tmp_path / "log.mcap")
    senders = {record.sender for record in log.records("/robot0/retina")}
    assert len(senders) == MAX_SENDERS
    messages = [m for m in loop_events(log) if isinstance(m, Message) and "retina" in m.key]
    assert messages == [m for batch in schedule.values() for m in batch]  # none is lost or changed
    assert replay(log).exit_status == 0


def test_a_large_message_of_one_sender_too_many_is_kept_whole(tmp_path):
    wide = replace(CONTRACT, retina=replace(CONTRACT.retina, rays=4096, channels=3, eyes=2))
    assert wide.retina.size < KEPT_BYTES  # the largest retina that a contract allows
    from reflexarc_logs.container.rejected import Intake, rejected_message
    from reflexarc_runtime.messages_pb2 import Rejected

    intake = Intake("robot0")
    message = nominal(1)[1][0]
    padded = message.payload + b"\x82\x7d" + b"\x80\x80\x08" + bytes(1 << 17)  # an unknown field
    for number in range(MAX_SENDERS + 1):
        stamp = pack_stamp(Stamp(0, 0, identity(1 + number)))
        sent = replace(message, payload=padded, attachment=stamp)
        entry = intake.sort(sent)
    assert entry.key == "robot0/rejected"
    rejected = Rejected.FromString(entry.payload)
    assert "more than 16" in rejected.reason
    assert rejected_message(rejected, sent.received_ns) == sent


def test_recovering_keeps_the_senders(policy, tmp_path):
    drive(tmp_path / "log.mcap", policy, from_many(3), TICKS)
    cut = tmp_path / "cut.mcap"
    cut.write_bytes((tmp_path / "log.mcap").read_bytes()[:-900])
    recovered = read_log(recover(cut, tmp_path / "fixed.mcap").path)
    whole = list(read_log(tmp_path / "log.mcap").records())
    assert list(recovered.records()) == whole[: len(list(recovered.records()))]
    assert {record.sender for record in recovered.records("/robot0/retina")} == {
        identity(1 + number) for number in range(3)
    }


def test_in_lockstep_identifiers_are_constant_and_differ_by_node():
    names = [lockstep_sender(node) for node in ("runtime", "body", "recorder", "a" * 40)]
    assert len(set(names)) == 4
    assert {len(name) for name in names} == {16}
    assert lockstep_sender("runtime") == b"lockstep runtime"
