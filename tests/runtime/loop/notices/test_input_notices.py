"""A person reads why inputs are refused, once a change; and that a sensor is too slow."""

import time
from dataclasses import replace

import pytest

from reflexarc_runtime.backlog import backlog_in_words
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.decision import Command, Decision, Input, Verdict
from reflexarc_runtime.loop.notices.input_notices import Notices
from reflexarc_runtime.loop.notices.sensor_period import SensorPeriod, misfit
from support.processes import wait_until

CONTRACT = PolicyContract()
MS = 1_000_000
DECISION = Decision(
    index=0,
    slot=0,
    now_ns=0,
    inputs=1,
    input=None,
    retina=b"",
    q_values=(),
    winner=-1,
    action=-1,
    verdict=Verdict.OK,
    reason="",
    command=Command(0, -1, Verdict.OK, 0.0, 0.0, 0.0, 0),
    policy_hash="",
)


def refused(reason: str) -> Decision:
    return replace(DECISION, verdict=Verdict.INVALID_INPUT, reason=reason)


def test_a_reason_is_said_once_and_numbers_make_no_new_one():
    said: list[str] = []
    with Notices(said.append, CONTRACT, "scan") as notices:
        for number in range(50):
            notices.saw(refused(f"scan: {number} of 16 rays unknown"))
        notices.saw(refused("retina of another eye"))
        wait_until(lambda: len(said) == 2, "two notices", 10.0)
    assert said == [
        "INVALID_INPUT: scan: 0 of 16 rays unknown",
        "INVALID_INPUT: retina of another eye",
    ]


def test_a_terminal_that_stands_still_holds_no_loop_up():
    def hang(_: str) -> None:
        time.sleep(3600)

    with Notices(hang, CONTRACT, "scan") as notices:
        for number in range(1000):
            notices.saw(refused("x" * (number % 50)))


@pytest.mark.parametrize(
    ("period_ms", "fits"), [(20, True), (99, True), (133, False), (182, False)]
)
def test_a_sensor_slower_than_the_policy_s_patience_is_named(period_ms: int, fits: bool):
    period = SensorPeriod()
    for number in range(6):
        period.saw(number * period_ms * MS)
        period.saw(number * period_ms * MS)  # the next tick uses it again
    assert period.period_ns == period_ms * MS
    words = misfit(period, CONTRACT, "scan")
    assert (not words) is fits
    if words:
        assert f"scans every {period_ms} ms, the policy takes inputs of at most 100 ms" in words


def test_too_slow_a_sensor_is_said_once():
    said: list[str] = []
    with Notices(said.append, CONTRACT, "scan") as notices:
        for number in range(20):
            used = Input(number, 0, number * 182 * MS, 0)
            notices.saw(replace(DECISION, input=used))
        wait_until(lambda: said, "a notice", 10.0)
    assert len(said) == 1
    assert "--max-input-age 0.5" in said[0]


@pytest.mark.parametrize(
    ("intervals_ms", "words"),
    [
        ([100] * 8, ""),
        ([99, 101] * 4, "scans every 100 ms, and often 101 ms"),
        ([20] * 8 + [500], ""),  # once is an accident
        ([182] * 8, "scans every 182 ms, the policy takes"),
    ],
)
def test_a_sensor_that_often_comes_too_late_is_named(intervals_ms: list[int], words: str):
    period, at_ms = SensorPeriod(), 0
    period.saw(0)
    for interval_ms in intervals_ms:
        at_ms += interval_ms
        period.saw(at_ms * MS)
    said = misfit(period, CONTRACT, "scan")
    assert said.startswith(words)
    assert bool(said) is bool(words)


def test_the_status_says_how_often_the_sensor_sends_and_when_it_does_no_longer():
    notices = Notices(lambda _: None, CONTRACT, "scan")
    assert notices.sensor(0) == ""
    for number in range(9):
        notices.saw(replace(DECISION, input=Input(number, 0, number * 20 * MS, 0)))
    assert notices.sensor(160 * MS) == "scans every 20 ms"
    assert notices.sensor(2160 * MS) == "no scan for 2.0 s"


def test_a_backlog_reaches_the_terminal():
    said: list[str] = []
    with Notices(said.append, CONTRACT, "scan") as notices:
        for tenths in range(5):
            reason = backlog_in_words(tenths * 100 * MS)
            notices.saw(replace(DECISION, verdict=Verdict.STALE_INPUT, reason=reason))
        wait_until(lambda: said, "a notice", 10.0)
    assert said == ["STALE_INPUT: 0.0 s behind its sender's best: a backlog"]
