"""Whom a body obeys, as a runtime that it does not obey is told."""

import pytest

from reflexarc.wiring.rivals import LOOK_AGAIN_NS, Rivals
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.messages.wire import Message

OWN, OTHER = b"o" * 16, b"\xab" * 16


def told_of(holders: list[bytes], apart_ns: int = LOOK_AGAIN_NS) -> list[str]:
    lines: list[str] = []
    rivals = Rivals(OWN, lines.append, "rover")
    for number, holder in enumerate(holders):
        payload = pb.Lease(holder=holder).SerializeToString()
        rivals.hear(Message("rover/lease", payload, "", b"", number * apart_ns))
    return lines


def test_a_second_runtime_is_told_once_whom_the_body_obeys():
    (line,) = told_of([OTHER] * 20)
    assert line.startswith("rover obeys another runtime, abababab, and not this one")


@pytest.mark.parametrize(
    "holders",
    [[OWN] * 20, [b""] * 20, [OTHER, OTHER, OWN, OTHER, OWN, b"", OTHER]],
    ids=["its own", "nobody's", "handed over"],
)
def test_no_other_lease_is_worth_a_word(holders: list[bytes]):
    assert told_of(holders) == []


def test_a_flood_of_holders_is_neither_read_nor_told():
    holders = [bytes([i, 1] * 8) for i in range(60) for _ in range(3)]
    assert len(told_of(holders)) == 4
    assert told_of(holders, apart_ns=1000) == []


def test_what_is_no_lease_is_nobody_s():
    lines: list[str] = []
    rivals = Rivals(OWN, lines.append, "rover")
    for number in range(9):
        rivals.hear(Message("rover/lease", b"\xff" * 9, "", b"", number * LOOK_AGAIN_NS))
    assert lines == []
