"""A loop's metrics, answered by a process of its own."""

import os
import signal
import time
import urllib.request
from contextlib import suppress

from hypothesis import given
from hypothesis import strategies as st

from reflexarc_runtime.messages.topics import STATUS
from reflexarc_runtime.messages.wire import MAX_PAYLOAD_BYTES, Message, protobuf_encoding
from reflexarc_runtime.metrics.feed import MetricsFeed, Overheard, pack_word, unpack_word
from reflexarc_runtime.metrics.listener import address_of, listener_at
from support.fleet_words import FIRST, lease, status
from support.processes import wait_until
from support.spoken import Spoken

TEXTS = st.text(max_size=40) | st.sampled_from(["", "a\0b", "\0" * 9])


@given(TEXTS, st.binary(max_size=200), TEXTS, st.binary(max_size=40))
def test_a_word_arrives_as_it_was_said_whatever_is_in_it(
    key: str, payload: bytes, encoding: str, attachment: bytes
):
    word = Message(key, payload, encoding, attachment, 77)
    assert unpack_word(pack_word(word), 77) == word


@given(st.binary(max_size=60))
def test_what_is_no_word_is_none_or_a_message_and_no_other_exception(word: bytes):
    with suppress(ValueError):
        unpack_word(word, 77)


def read(address: str) -> str:
    with urllib.request.urlopen(address, timeout=30.0) as answer:
        return str(answer.read().decode())


def test_what_a_loop_says_is_scraped_from_another_process_and_its_death_costs_nothing():
    listener = listener_at("127.0.0.1", 0)
    address = address_of(listener)
    with MetricsFeed(listener) as feed:
        sent = Spoken()
        encoding = protobuf_encoding(STATUS.schema)
        outlet = Overheard(sent, "rover/status", encoding, FIRST, feed)
        payload = status(verdicts={"OK": 41}).payload
        outlet.put(payload, 5)
        feed.hear(lease("rover", holder=FIRST, armed=True))
        feed._link.send(b"\xff" * 30)  # no word of any loop; the process goes on
        feed.hear(lease("ro\0ver", sender=FIRST))
        wait_until(lambda: 'armed{robot="rover"} 1.0' in read(address), "an armed robot")
        assert 'reflexarc_ticks_total{robot="rover",verdict="OK"} 41.0' in read(address)
        feed.hear(Message("rover/status", bytes(MAX_PAYLOAD_BYTES), "", b"", 0))  # no room: no word
        os.kill(feed.pid, signal.SIGSTOP)
        began_s = time.monotonic()
        for _ in range(5000):  # more than the socket holds
            outlet.put(payload, 6)
        assert time.monotonic() - began_s < 60.0  # it did not wait for who is stopped
        os.kill(feed.pid, signal.SIGKILL)
        wait_until(lambda: _has_ended(feed.pid), "the end of the process")
        outlet.put(payload, 7)
        assert len(sent.said) == 5002
        assert sent.said[-1] == (payload, 7)


def _has_ended(pid: int) -> bool:
    with open(f"/proc/{pid}/stat") as file:
        return file.read().rpartition(")")[2].split()[0] == "Z"
