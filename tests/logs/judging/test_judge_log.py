"""A candidate on one log, compared with the slow way and with `replay`."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from reflexarc_logs.container.run_info import RUN
from reflexarc_logs.cutting.span import span_of
from reflexarc_logs.judging import flip_tally
from reflexarc_logs.judging.answers import Answers, JudgedTick
from reflexarc_logs.judging.flip_limits import FlipLimits
from reflexarc_logs.judging.flip_tally import FlipTally
from reflexarc_logs.judging.judge_log import judge_log
from reflexarc_logs.judging.judgement import LogJudgement
from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.replaying.comparison import EqualityRules
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages_pb2 import Decision
from reflexarc_runtime.policy.policy import LoadedPolicy, load_policy
from support.policies import exported
from support.recordings import CONTRACT
from support.remembering import remembering_policy
from support.remembering_drives import drive_remembering
from support.rewriting import edit_decisions, rewrite
from support.slow_judge import decisions, slow_flips

ALL = FlipLimits()


def judged(path: Path, candidate: LoadedPolicy, limits: FlipLimits = ALL) -> LogJudgement:
    return judge_log(read_log(path), candidate, limits)


def test_every_flip_is_the_one_that_is_found_tick_by_tick(driven, candidate, candidate_file):
    found, slow = judged(driven, candidate), slow_flips(driven, candidate_file.read_bytes())
    assert found.flips == len(slow) > 50
    assert found.reversals == sum(one.is_reversal for one in slow) > 10
    assert found.ticks == sum(bool(one.q_values) for one in decisions(driven))
    assert found.largest_margin == max(one.margin for one in slow)
    assert (found.first_tick, found.first_s) == (slow[0].tick, slow[0].time_s)
    rows = [(f.tick, f.time_s, f.recorded, f.candidate, f.margin) for f in found.shown_flips]
    assert rows == [(f.tick, f.time_s, f.recorded, f.candidate, f.margin) for f in slow]
    for flip, other in zip(found.shown_flips, slow, strict=True):
        assert flip.is_reversal == other.is_reversal
        assert flip.candidate_q_values == pytest.approx(other.candidate_q_values, rel=1e-5)
        values = other.candidate_q_values
        lead = values[other.candidate] - values[other.recorded]
        assert flip.candidate_margin == pytest.approx(lead, abs=1e-4)
        assert flip.retina == decisions(driven)[flip.tick].retina


def test_the_flips_are_those_of_a_replay(driven, candidate):
    level = replay(driven, policy=candidate, level="policy").levels[0]
    found = judged(driven, candidate)
    assert [f.tick for f in level.flips] == [f.tick for f in found.shown_flips]
    assert level.compared == found.ticks


@pytest.mark.parametrize("margin", [0.05, 0.3, 1.0])
def test_flips_of_a_small_margin_do_not_count(driven, candidate, candidate_file, margin):
    slow = slow_flips(driven, candidate_file.read_bytes())
    found = judged(driven, candidate, FlipLimits(margin=margin))
    assert found.flips == sum(one.margin >= margin for one in slow)
    assert found.below_margin == sum(one.margin < margin for one in slow)


@pytest.mark.parametrize(
    ("since", "until"), [("50", "58"), ("1s", "1.16s"), ("", "2s"), ("3s", "")]
)
def test_only_ticks_of_the_window_count(driven, candidate, candidate_file, since, until):
    span = span_of(read_log(driven), since, until)
    inside = range(span.first, span.end)
    slow = slow_flips(driven, candidate_file.read_bytes())
    found = judged(driven, candidate, FlipLimits(since=since, until=until))
    assert [f.tick for f in found.shown_flips] == [f.tick for f in slow if f.tick in inside]
    asked = [one for one in decisions(driven) if one.q_values and one.index in inside]
    assert found.ticks == len(asked)
    assert all(one.tick in inside for one in found.incidents)


def test_what_the_candidate_prefers_is_said_at_each_incident(driven, candidate):
    found = {(one.kind, one.tick): one for one in judged(driven, candidate).incidents}
    assert list(found) == [("contact", 120), ("mark", 200), ("stop", 249)]
    for (_, tick), one in found.items():
        asked = [d for d in decisions(driven) if d.index <= tick and d.q_values][-1]
        stack = np.frombuffer(asked.retina, np.uint8).reshape(1, 1, 1, 16, 1)
        now = int(candidate.decide(stack)[1][0])
        assert (one.asked_tick, one.recorded, one.candidate) == (asked.index, asked.winner, now)
    assert found["stop", 249].asked_tick == 248
    assert found["contact", 120].time_s == pytest.approx(2.4)


def test_the_recorded_policy_is_within_any_limits(driven):
    own = load_policy(read_log(driven).policy)
    found = judged(driven, own, FlipLimits(max_flips="0", max_reversals=0))
    assert (found.flips, found.exit_status) == (0, 0)


def test_limits_are_kept_to_the_flip(driven, candidate):
    flips, ticks = (found := judged(driven, candidate)).flips, found.ticks
    for word, status in ((f"{flips}", 0), (f"{flips - 1}", 1), ("100%", 0), ("0%", 1)):
        assert judged(driven, candidate, FlipLimits(word)).exit_status == status
    assert found.exit_status == 1
    assert found.broken == (f"{flips} flips ({100 * flips / ticks:.1f}%) of at most 0",)
    assert judged(driven, candidate, FlipLimits(max_reversals=flips)).exit_status == 0
    few = judged(driven, candidate, FlipLimits(max_reversals=found.reversals - 1))
    assert few.broken == (f"{found.reversals} reversals of at most {found.reversals - 1}",)


def test_of_many_flips_those_of_the_largest_margins_are_kept(driven, candidate, monkeypatch):
    everything = judged(driven, candidate)
    monkeypatch.setattr(flip_tally, "MOST_KEPT", 7)
    few = judged(driven, candidate)
    clearest = sorted(everything.shown_flips, key=lambda f: (-f.margin, f.tick))[:7]
    assert list(few.shown_flips) == sorted(clearest, key=lambda f: f.tick)
    assert few.flips == everything.flips == 7 + few.more_flips


def test_what_is_written_as_json_is_read_back(driven, candidate):
    found = judged(driven, candidate)
    assert LogJudgement.from_plain(found.to_plain()) == found


def test_a_candidate_with_a_memory_is_asked_in_order_as_in_a_replay(tmp_path):
    path = drive_remembering(tmp_path / "drive.mcap", 0)
    for seed in (0, 1):
        policy = load_policy(remembering_policy(seed))
        level = replay(path, policy=policy, level="policy").levels[0]
        found = judged(path, policy)
        assert (found.flips, found.ticks) == (len(level.flips), level.compared)
        assert found.warming_up == level.warming_up
        assert [f.tick for f in found.shown_flips] == [f.tick for f in level.flips]
        assert (found.flips > 0) == (seed != 0)


def turned_round() -> bytes:
    """The same eye, and the actions left and right the other way round."""
    stay, left, right = CONTRACT.actions
    return exported(dataclasses.replace(CONTRACT, actions=(stay, right, left)), 4)


def other_eye() -> bytes:
    eye = dataclasses.replace(CONTRACT.retina, fov_rad=2.0)
    return exported(dataclasses.replace(CONTRACT, retina=eye), 4)


@pytest.mark.parametrize(
    ("other", "words"),
    [(turned_round, "go other ways"), (other_eye, r"another eye .*fov_rad 3\.14\d* → 2\.0")],
)
def test_a_candidate_that_means_something_else_is_not_judged(driven, other, words):
    with pytest.raises(LogError, match=words):
        judged(driven, load_policy(other()))


def test_only_scans_can_be_looked_at_by_another_eye(driven, tmp_path):
    """Retinas name their eye: a loop with another one refuses each of them."""
    with pytest.raises(LogError, match="no other eye can look at recorded retinas"):
        judged(driven, load_policy(other_eye()))
    scans = rewrite(driven, tmp_path / "of a scan.mcap", metadata={RUN: {"input": "scan"}})
    with pytest.raises(LogError, match=r"`reflexarc decide '.*of a scan.mcap' --policy "):
        judged(scans, load_policy(other_eye()))


def test_actions_of_other_speeds_and_another_rate_are_said(driven):
    faster = tuple(Action(a.name, 2 * a.linear_mps, 2 * a.lateral_mps) for a in CONTRACT.actions)
    quick = dataclasses.replace(CONTRACT, actions=faster, rate_hz=100.0)
    notes = judged(driven, load_policy(exported(quick, 4))).notes
    assert notes == (
        "recorded at 50 Hz, the candidate wants 100 Hz",
        "the candidate's actions have other speeds than the recorded ones",
    )


@pytest.mark.parametrize("window", [("1000", ""), ("", "0"), ("251", "290")])
def test_a_window_without_a_tick_that_was_asked_is_not_judged(driven, candidate, window):
    with pytest.raises(LogError, match="found none in the window"):
        judged(driven, candidate, FlipLimits(since=window[0], until=window[1]))


def test_ticks_of_another_policy_are_left_out_and_said(driven, candidate, tmp_path):
    def rename(decision: Decision) -> None:
        if decision.index < 100:
            decision.policy_hash = "ab" * 32

    found = judged(rewrite(driven, tmp_path / "two.mcap", edit_decisions(rename)), candidate)
    whole = judged(driven, candidate)
    asked = [d for d in decisions(driven) if d.index < 100 and d.q_values]
    assert found.ticks == whole.ticks - len(asked)
    assert found.notes == (f"{len(asked)} ticks name another policy than the log: not judged",)


def test_q_values_that_are_not_finite_are_no_flips_and_beyond_any_limit():
    decision = Decision(index=3, winner=0, q_values=[2.0, 1.0, 0.0], retina=bytes(16))
    rules = EqualityRules(exact=True, same_policy=False)
    tally = FlipTally(FlipLimits("100%"), rules, CONTRACT.actions, has_winner=True)
    values = np.array([[np.nan, 1.0, 2.0], [0.0, 1.0, 2.0]], np.float32)
    ticks = [JudgedTick(decision, 0, True)] * 2
    tally.add(Answers(ticks, values, np.array([0, 2]), is_warm=True))
    found = tally.result()
    assert (found["ticks"], found["flips"], found["faults"]) == (2, 1, 1)
    assert found["broken"] == ("its Q-values are not finite at 1 tick: the loop would stop",)
