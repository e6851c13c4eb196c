"""The attacks of the campaign: they hold, and a body that is fooled is reported."""

from dataclasses import replace
from pathlib import Path

import pytest

from campaigns.attacks import strangers
from campaigns.attacks.__main__ import tried
from campaigns.attacks.lies import LIES
from campaigns.attacks.outcome import Held, Outcome, row, table
from campaigns.attacks.stage import Stage
from support.gullible_body import gullible_body

CHEAP = (
    "of time 0, valid for 2⁶³−1 ns, without attachment",
    "in order, but text/plain",
    "speed +∞",
)


@pytest.fixture
def stage(policy: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Stage:
    monkeypatch.setattr(strangers, "LIES", {name: LIES[name] for name in CHEAP})
    monkeypatch.setattr(strangers, "WATCHED_S", 0.4)
    return Stage(policy, tmp_path)


def test_no_lie_moves_the_body(stage: Stage):
    outcomes = [*tried(strangers.once_and_gone, stage), *tried(strangers.in_every_respect, stage)]
    assert len(outcomes) == 1 + len(CHEAP)
    assert {outcome.held for outcome in outcomes} == {Held.YES}
    assert {outcome.distance_m for outcome in outcomes} == {0.0}
    assert [outcome.said.partition(" × ")[2] for outcome in outcomes[1:]] == [
        "no attachment that names a sender",
        "another encoding, or too long",
        "unreadable, or speeds that are not finite",
    ]


def test_a_body_that_believes_everything_is_reported(stage: Stage):
    fooled = replace(stage, bodies=gullible_body)
    [once] = tried(strangers.once_and_gone, fooled)
    assert (once.held, once.distance_m > 0.1) == (Held.NO, True)
    lies = [*tried(strangers.in_every_respect, fooled)]
    assert [outcome.held for outcome in lies] == [Held.NO] * len(CHEAP)


def test_an_attack_that_breaks_has_not_shown_that_anything_holds(stage: Stage):
    def broken(stage: Stage):
        raise AssertionError("not within 30 s")
        yield

    [outcome] = tried(broken, stage)
    assert outcome.held is Held.NO
    assert "not within 30 s" in outcome.said


def test_a_row_is_one_line_of_markdown():
    outcome = Outcome("a | b", "once", None, "two\nlines", Held.YES)
    assert row(outcome) == "| a \\| b | once | – | two lines | yes |"
    assert len(table([outcome]).splitlines()) == 3
