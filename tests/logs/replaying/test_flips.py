"""Some of the trials of `tests/campaigns/flips.py`: does replay of damaged logs tell the truth?"""

import random

import pytest

from reflexarc_logs.replaying.replay import replay
from support.flip_judge import Contents, FlipJudge, contents, untruths, without_checks
from support.rewriting import rewrite


@pytest.fixture(params=["checked", "without a CRC"])
def judge(request, log_path, tmp_path):
    plain = request.param == "without a CRC"
    path = without_checks(log_path, tmp_path / "plain.mcap") if plain else log_path
    return FlipJudge(path, tmp_path)


def test_a_log_that_is_cut_anywhere_is_never_called_different(judge):
    dice = random.Random(1)
    assert [wrong for _ in range(15) for wrong in judge.cut(dice)] == []
    assert judge.seen["recovered: identical"] > 5


def test_a_log_with_a_flipped_bit_is_never_called_identical_where_it_is_not(judge):
    dice = random.Random(2)
    assert [wrong for _ in range(40) for wrong in judge.flip(dice)] == []
    assert sum(judge.seen.values()) == 80


@pytest.mark.parametrize("offset", [8, 14], ids=["its length", "that of its list"])
def test_an_index_that_lies_about_its_length_hides_no_tick(log_path, tmp_path, offset):
    judge = FlipJudge(without_checks(log_path, tmp_path / "plain.mcap"), tmp_path)
    data = bytearray(judge.data)
    data[judge.data.index(b"\x07", judge.indexes[0].start - 1) + offset] ^= 0x40
    assert judge.attempt(bytes(data)) == []
    assert judge.seen["recovered: identical"] == 1


def test_the_judge_sees_each_kind_of_untruth(log_path, tmp_path):
    whole, report = contents(log_path), replay(log_path)
    fewer = rewrite(log_path, tmp_path / "fewer.mcap", lambda t, n, p: None if n == 30 else p)
    found = contents(fewer)
    assert untruths(whole, Contents(found.rows, whole.head), report) == [
        "identical, though a tick or command was changed or is missing",
        "identical, though ticks are missing and no note says so",
    ]
    wrong = replay(rewrite(log_path, tmp_path / "wrong.mcap", backwards))
    assert untruths(whole, whole, wrong) == ["different, though nothing was changed"]
    assert untruths(whole, contents(tmp_path / "wrong.mcap"), wrong) == []


def backwards(topic: str, nth: int, payload: bytes) -> bytes:
    from reflexarc_runtime.messages_pb2 import Command

    if not topic.endswith("/command"):
        return payload
    command = Command.FromString(payload)
    command.linear_mps *= -1
    return command.SerializeToString()
