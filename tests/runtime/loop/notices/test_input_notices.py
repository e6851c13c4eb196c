"""A person reads why inputs are refused, once a change; and that a sensor is too slow."""

import time
from dataclasses import replace

import pytest

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
    assert "--max-input-age 0.4" in said[0]
