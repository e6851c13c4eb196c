import json
import math
import struct
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_logs.replaying.comparison import EqualityRules, Tally, find_flip, is_close
from reflexarc_logs.replaying.message_fields import Difference, Fields
from reflexarc_logs.replaying.report import Divergence, Flip, LevelResult, ReplayReport
from reflexarc_runtime.messages_pb2 import Command, Decision, Input
from reflexarc_runtime.policy.agreement import Q_TOLERANCE, flips, within_tolerance

EXACT = EqualityRules(exact=True, same_policy=True)
TOLERANT = EqualityRules(exact=False, same_policy=True)
FIELDS = Fields(Decision.DESCRIPTOR, Decision.DESCRIPTOR)


def differences(recorded: Decision, replayed: Decision) -> list[str]:
    return [difference.path for difference in FIELDS.differences(recorded, replayed)]


def test_a_decision_has_twenty_six_fields_to_compare():
    # 11 of its own that are no message, 4 of Input, 10 of Command, and policy_hash
    assert FIELDS.count == 11 + 4 + 10 + 1
    assert FIELDS.not_compared == ()


def test_each_field_that_differs_is_named_by_its_path():
    recorded = Decision(index=1, retina=b"abc", q_values=[1, 2], command=Command(linear_mps=1))
    replayed = Decision(index=2, retina=b"abd", q_values=[1, 3], command=Command(linear_mps=2))
    assert differences(recorded, replayed) == [
        "index",
        "retina[2]",
        "q_values[1]",
        "command.linear_mps",
    ]


def test_presence_is_compared_where_a_field_has_it():
    absent = Decision(command=Command(), input=Input())
    present = Decision(command=Command(source_sequence=0))
    assert differences(absent, present) == ["input", "command.source_sequence"]


def test_zeros_of_different_sign_differ_and_a_nan_equals_its_own_bits():
    nan, other_nan = struct.unpack("<2f", struct.pack("<2I", 0x7FC00000, 0x7FC00001))
    assert differences(Decision(q_values=[0.0]), Decision(q_values=[-0.0])) == ["q_values[0]"]
    assert differences(Decision(q_values=[nan]), Decision(q_values=[nan])) == []
    assert differences(Decision(q_values=[nan]), Decision(q_values=[other_nan])) == ["q_values[0]"]


decisions = st.builds(
    Decision,
    index=st.integers(0, 3),
    retina=st.binary(max_size=2),
    q_values=st.lists(st.floats(width=32), max_size=2),
    reason=st.sampled_from(["", "x"]),
    command=st.none() | st.builds(Command, linear_mps=st.floats(), action=st.integers(-1, 1)),
)


@given(recorded=decisions, replayed=decisions)
def test_two_decisions_are_equal_where_their_bytes_are(recorded, replayed):
    same_bytes = recorded.SerializeToString() == replayed.SerializeToString()
    assert (differences(recorded, replayed) == []) == same_bytes


values = st.lists(st.floats(-2, 2, width=32), min_size=3, max_size=3)


@given(q_values=values, recorded=st.integers(0, 2), replayed=st.integers(0, 2))
def test_a_flip_is_rounding_where_the_runtime_says_so(q_values, recorded, replayed):
    flip = find_flip(0, q_values, recorded, replayed)
    behaviour = flips(np.array([replayed]), np.array([recorded]), np.array([q_values], np.float64))[
        0
    ]
    assert (flip is None) == (recorded == replayed)
    assert flip is None or flip.rounding != behaviour


@given(recorded=st.floats(-10, 10, width=32), step=st.floats(-3e-6, 3e-6))
def test_two_values_are_close_where_the_runtime_says_so(recorded, step):
    replayed = recorded + step
    agreed = within_tolerance(np.array([replayed]), np.array([recorded]))
    assert is_close(recorded, replayed) == agreed


def test_the_margin_is_that_of_the_recorded_values_by_hand():
    assert find_flip(7, (0.5, 0.25, 0.0), 0, 1) == Flip(7, 0, 1, 0.25, rounding=False)
    near = find_flip(7, (0.5, 0.5 - 3e-7, 0.0), 0, 1)
    assert near is not None
    assert near.rounding
    assert near.margin == pytest.approx(3e-7)
    margins = {1.9e-6: True, 2.1e-6: False}  # twice the tolerance of one value, 1e-6
    for margin, rounding in margins.items():
        flip = find_flip(7, (0.5, 0.5 - margin), 0, 1)
        assert flip is not None
        assert flip.rounding == rounding
    assert find_flip(7, (0.5, 0.25), 0, -1) is None


def test_what_is_not_finite_is_close_to_itself_alone():
    assert is_close(math.nan, math.nan)
    assert is_close(math.inf, math.inf)
    assert not is_close(math.inf, -math.inf)
    assert not is_close(1.0, math.nan)


def test_rounding_excuses_what_follows_from_the_action_and_nothing_else():
    flip = Flip(1, 0, 1, Q_TOLERANCE, rounding=True)
    found = [Difference(path, "0", "1") for path in ("action", "command.linear_mps", "verdict")]
    assert [d.path for d in TOLERANT.judge(found, flip)] == ["verdict"]
    assert TOLERANT.judge(found, None) == found
    assert TOLERANT.judge(found, replace(flip, rounding=False)) == found
    assert EXACT.judge(found, flip) == found


def report(*levels: LevelResult) -> ReplayReport:
    return ReplayReport("run.mcap", "ab" * 32, True, "numpy", "numpy", ("stay", "left"), levels)


@pytest.mark.parametrize(
    ("levels", "status"),
    [
        ([(10, 10), (10, 10)], 0),
        ([(10, 10), (10, 9)], 1),
        ([(0, 0), (10, 10)], 0),
        ([(0, 0)], 2),
        ([], 2),
    ],
)
def test_the_exit_status_says_equal_different_or_nothing_compared(levels, status):
    results = [LevelResult("policy", 10, compared, same, 0) for compared, same in levels]
    assert report(*results).exit_status == status


def test_the_report_says_counts_then_the_first_divergence_then_the_flips():
    tally = Tally("policy", EXACT, ticks=3)
    tally.add(0, 2, [])
    tally.add(1, 2, [Difference("action", "0", "1")], Flip(1, 0, 1, 0.4, rounding=False))
    tally.add(2, 2, [Difference("q_values[0]", "0.1", "0.2")])
    text = report(tally.result(not_compared=("mood",))).lines()
    assert text[0] == "run.mcap: different"
    assert text[3:] == [
        "  level policy: 3 ticks, 3 compared, 1 identical; 6 fields",
        "    not compared: mood",
        "    first divergence: tick 1, action: 0 → 1",
        "    flips: 1 (0 rounding, 1 behaviour change)",
        "      tick 1: stay → left, margin 0.4: behaviour change",
    ]


def test_a_report_of_a_thousand_flips_stays_under_forty_lines_and_keeps_them_all_in_json():
    found = tuple(Flip(i, 0, 1, 0.5, rounding=False) for i in range(1000))
    first = Divergence(0, "action", "0", "1")
    level = LevelResult("policy", 1000, 1000, 0, 2000, first=first, flips=found)
    whole = report(level, level)
    assert len(whole.lines()) < 40
    document = json.loads(json.dumps(whole.as_dict()))
    assert len(document["levels"][0]["flips"]) == 1000
    assert (document["exit_status"], document["verdict"]) == (1, "different")
    assert document["levels"][0]["first"]["path"] == "action"
