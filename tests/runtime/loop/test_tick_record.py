from reflexarc_runtime.loop.tick_record import LoopIdentity, TickRecord
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp

LOOP = LoopIdentity("rover1", b"s" * 16)
HEARD = tuple(Message("rover1/retina", bytes(n), "e", b"", n) for n in (3, 5))


def test_it_holds_what_came_then_the_tick_then_the_command():
    record = TickRecord(HEARD, b"tick", b"command", 7, 90, LOOP)
    stamp = pack_stamp(Stamp(7, 90, b"s" * 16))
    own = "application/protobuf;reflexarc."
    assert list(record.messages()) == [
        *HEARD,
        Message("rover1/tick", b"tick", own + "Tick", stamp, 90),
        Message("rover1/command", b"command", own + "Command", stamp, 90),
    ]
    assert record.extent() == (4, 3 + 5 + 4 + 7)


def test_a_command_that_was_not_sent_is_not_in_it():
    record = TickRecord((), b"tick", None, 7, 90, LOOP)
    assert [message.key for message in record.messages()] == ["rover1/tick"]
    assert record.extent() == (1, 4)
