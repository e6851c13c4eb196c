"""Logs of loops whose policy was swapped: they replay to the bit, whole and in parts."""

import shutil
from collections.abc import Collection
from dataclasses import replace
from itertools import count, pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from reflexarc_logs.cutting.cut import cut
from reflexarc_logs.cutting.join import join
from reflexarc_logs.cutting.span import TickSpan
from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.reading.summary import summarise
from reflexarc_logs.recording.black_box import BoxSpan
from reflexarc_logs.recording.keeping import Keeping
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.contract.body_spec import Footprint
from reflexarc_runtime.decision import Decision
from reflexarc_runtime.errors import DecisionEndedError
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.messages.wire import Message
from reflexarc_runtime.policy.model_file import policy_hash
from reflexarc_runtime.policy.policy import LoadedPolicy
from support.policies import exported
from support.recordings import CONTRACT, RUN, retina_at
from support.remembering import REMEMBERING, remembering_policy
from support.swapped_drives import (
    fails_in_the_light,
    overrun_at,
    reset_at,
    stop_at,
    swap_at,
    swapped_drive,
    verdicts,
)

GUARD = GuardSettings(footprint=Footprint(radius_m=0.1), deceleration_mps2=2.0)
GUARDED_RUN = replace(RUN, guard=GUARD.to_json())
HOLDING = replace(CONTRACT, hold_s=0.1, margin=0.1)
TICKS = 2000
SWAPS = 100


def waves(ticks: int, seed: int = 0) -> dict[int, list[Message]]:
    """Retinas in which things come near and go again, now and then very bright ones."""
    rng = np.random.default_rng(seed)
    phases = rng.uniform(0, 2.0, CONTRACT.retina.rays)
    slots = np.arange(ticks)[:, None]
    values = 110 + 80 * np.sin(slots / 9 + phases) + 40 * np.sin(slots / 31)
    pixels = np.clip(values, 0, 254).astype(np.uint8).reshape(ticks, *CONTRACT.retina.shape)
    return {slot: [retina_at(slot, pixels[slot - 1])] for slot in range(1, ticks)}


def four() -> list[bytes]:
    """Policies that take over from each other: one holds its actions, one fails in the light."""
    plain, holding = exported(CONTRACT, seed=1), exported(HOLDING, seed=2)
    return [plain, holding, fails_in_the_light(CONTRACT, seed=3), exported(CONTRACT, seed=4)]


def eventful(policies: list[bytes]) -> dict[int, list[Message]]:
    """A hundred swaps, with stops, resets and overruns, a silence and a second body."""
    schedule = waves(TICKS)
    for number in range(SWAPS):
        slot = 12 + 19 * number
        at_once, named = number % 5 != 0, policies[(number + 1) % len(policies)]
        schedule[slot] = [*schedule[slot], swap_at(slot, named, while_moving=at_once)]
        if number % 5 == 0:
            schedule[slot + 5] = [stop_at(slot + 5), *schedule[slot + 5]]
            schedule[slot + 9] = [*schedule[slot + 9], reset_at(slot + 9)]
        if number % 7 == 0:
            schedule[slot + 14] = [overrun_at(slot + 14), *schedule[slot + 14]]
        if number % 11 == 0:
            for quiet in range(slot + 2, slot + 10):
                schedule[quiet] = [m for m in schedule[quiet] if "retina" not in m.key]
    return schedule


def changes(decided: list[Decision]) -> int:
    """How often another policy decided than at the tick before."""
    hashes = [one.policy_hash for one in decided]
    return sum(was != now for was, now in pairwise(hashes))


@pytest.fixture(scope="module")
def eventful_log(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Decision]]:
    path = tmp_path_factory.mktemp("swapped") / "hundred.mcap"
    policies = four()
    decided = swapped_drive(
        path,
        policies,
        eventful(policies),
        TICKS,
        run=GUARDED_RUN,
        shadow=exported(HOLDING, seed=9),
    )
    return path, decided


def test_a_log_with_100_swaps_shadows_stops_guards_and_overruns_replays_identically(eventful_log):
    path, decided = eventful_log
    seen = verdicts(decided)
    assert changes(decided) >= 60
    assert sum("rolled back to" in one.reason for one in decided) >= 5
    assert min(seen[name] for name in ("OK", "GUARDED", "STOPPED", "OVERRUN", "RECOVERING")) >= 10
    report = replay(path)
    assert report.verdict == "identical", str(report)
    policy, node, shadow = report.levels
    assert (node.level, node.compared, node.identical) == ("node", TICKS + 1, TICKS + 1)
    assert policy.ticks == TICKS + 1
    assert policy.compared == policy.identical > 1000
    assert shadow.level == "shadow"
    assert shadow.compared == shadow.identical > 900
    assert not report.notes
    used = {stream.topic: stream.use for stream in report.streams}
    assert used["/robot0/swap"] == "input"
    assert used["/robot0/shadow"] == used["/robot0/keyframe"] == "compared"


def decisions_ended(
    monkeypatch: pytest.MonkeyPatch, policy: bytes, at_its: Collection[int]
) -> None:
    """Let some decisions of a policy be ended, as by a watchdog; the first one is its first."""
    plain, asked = LoadedPolicy.decide, count(1)

    def decide(self: LoadedPolicy, *given: Any) -> Any:
        if self.policy_hash == policy_hash(policy) and next(asked) in at_its:
            raise DecisionEndedError
        return plain(self, *given)

    monkeypatch.setattr(LoadedPolicy, "decide", decide)


@pytest.mark.parametrize(
    ("at_its", "is_back"), [([1], True), ([20], False), ([20, 21], True), ([20, 30], False)]
)
def test_a_log_says_whose_decision_was_ended_and_replays_the_roll_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, at_its: list[int], is_back: bool
):
    path, policies = tmp_path / "ended.mcap", [exported(CONTRACT, seed=n) for n in (1, 2)]
    schedule = waves(120)
    schedule[30] = [*schedule[30], swap_at(30, policies[1], while_moving=True)]
    with monkeypatch.context() as patched:
        decisions_ended(patched, policies[1], at_its)
        decided = swapped_drive(path, policies, schedule, 110)
    assert any("rolled back to" in one.reason for one in decided) == is_back
    assert decided[-1].policy_hash == policy_hash(policies[not is_back])
    assert {one.verdict.name for one in decided[29:]} >= {"OK", "OVERRUN", "RECOVERING"}
    said = [pb.Overrun.FromString(one.payload) for one in read_log(path).records("/robot0/overrun")]
    assert [one.ended_policy for one in said] == [policy_hash(policies[1])] * len(at_its)
    report = replay(path)
    assert report.verdict == "identical", str(report)
    assert {level.level: level.compared for level in report.levels}["node"] == len(decided)


@pytest.mark.parametrize("first", [37, 700, 1500])
def test_what_is_cut_out_behind_swaps_replays_by_itself(eventful_log, tmp_path, first):
    path, decided = eventful_log
    part = tmp_path / "part.mcap"
    cut(read_log(path), TickSpan(first, first + 30), part)
    report = replay(part)
    assert report.verdict == "identical", str(report)
    assert {level.level: level.compared for level in report.levels}["node"] == 30
    hashes = {one.policy_hash for one in decided[first : first + 30]}
    attached = read_log(part).attachments
    assert f"policy-{decided[first - 1].policy_hash}.onnx" in attached or hashes <= {
        read_log(part).run.policy_hash
    }


def test_one_bit_of_a_swapped_policys_choice_is_noticed(eventful_log, tmp_path, monkeypatch):
    """So the replay is none that compares nothing."""
    path, _ = eventful_log
    from reflexarc_runtime.serving import swapping

    def never_back(self, state, why):  # type: ignore[no-untyped-def]
        return "", state

    monkeypatch.setattr(swapping.SwappingController, "_back", never_back)
    assert replay(path).verdict == "different"


def test_a_candidate_is_asked_about_the_ticks_of_all_policies(eventful_log, tmp_path):
    path, _ = eventful_log
    candidate = tmp_path / "candidate.onnx"
    candidate.write_bytes(exported(CONTRACT, seed=77))
    report = replay(path, policy=candidate, level="policy")
    (policy,) = (level for level in report.levels if level.level == "policy")
    assert policy.compared > 1000
    assert not any("another policy" in note for note in report.notes)


def test_a_part_that_begins_behind_a_swap_holds_the_policy_that_serves(tmp_path):
    policies = [exported(CONTRACT, seed=1), exported(CONTRACT, seed=2)]
    schedule = waves(300)
    schedule[20] = [*schedule[20], swap_at(20, policies[1], while_moving=True)]
    beside = {policy_hash(policies[1]): policies[1]}
    path = tmp_path / "rotated.mcap"
    swapped_drive(
        path, policies, schedule, 300, others=beside, keeping=Keeping(rotate_bytes=40_000)
    )
    later = path.with_name("rotated.part2.mcap")
    report = replay(later)
    assert report.verdict == "identical", str(report)
    assert report.levels[0].compared > 20
    assert {t.decision.policy_hash for t in read_log(later).ticks()} == set(beside)


def many_swaps(ticks: int) -> tuple[list[bytes], dict[int, list[Message]]]:
    """Another policy every 40 ticks, none of them twice."""
    policies = [exported(CONTRACT, seed=n) for n in range(ticks // 40)]
    schedule = waves(ticks)
    for number, policy in enumerate(policies[1:], 1):
        slot = 40 * number
        schedule[slot] = [*schedule[slot], swap_at(slot, policy, while_moving=True)]
    return policies, schedule


@pytest.mark.parametrize("before_s", [2.0, 5.0, 9.0])
def test_a_black_box_holds_who_served_where_it_begins_however_many_took_over_since(
    tmp_path, before_s
):
    """Nobody tells the recorder which policies there are."""
    policies, schedule = many_swaps(600)
    schedule[560] = [*schedule[560], stop_at(560)]
    path = tmp_path / "box.mcap"
    swapped_drive(path, policies, schedule, 600, box=BoxSpan(before_s, 0.3))
    (box,) = tmp_path.glob("*.mcap")
    log = read_log(box)
    first = next(iter(log.ticks())).decision
    assert first.policy_hash in {policy_hash(one) for one in policies[1:]}
    beside = [name for name in log.attachments if name.startswith("policy-")]
    assert 1 <= len(beside) <= 3
    report = replay(box)
    assert report.verdict == "identical", str(report)
    assert {level.level: level.compared for level in report.levels}["node"] == report.levels[
        0
    ].ticks


def test_parts_hold_who_serves_where_they_begin_though_the_recorder_was_told_of_nobody(tmp_path):
    policies, schedule = many_swaps(400)
    swapped_drive(tmp_path / "drive.mcap", policies, schedule, 400, keeping=Keeping(rotate_s=1.0))
    parts = sorted(tmp_path.glob("*.mcap"))
    assert len(parts) >= 5
    for part in parts:
        report = replay(part)
        assert report.verdict == "identical", str(report)
        assert not any("another policy" in note for note in report.notes), report.notes


@pytest.mark.parametrize("lost", [None, 1, 2])
def test_a_whole_holds_who_served_in_its_parts_also_where_the_swap_is_lost(tmp_path, lost):
    """The swap stands in the second part; the first one was begun when nobody had taken over."""
    policies = [exported(CONTRACT, seed=1), exported(CONTRACT, seed=2)]
    schedule, beside = waves(300), {policy_hash(policies[1]): policies[1]}
    schedule[90] = [*schedule[90], swap_at(90, policies[1], while_moving=True)]
    keeping = Keeping(rotate_s=1.0)
    for folder, others in (("before", {}), ("later", beside)):
        (tmp_path / folder).mkdir()
        path = tmp_path / folder / "drive.mcap"
        swapped_drive(path, policies, schedule, 300, others=others, keeping=keeping)
    first, second, third = (f"drive{name}.mcap" for name in ("", ".part2", ".part3"))
    shutil.copyfile(tmp_path / "before" / first, tmp_path / "later" / first)
    swaps = [
        list(read_log(tmp_path / "later" / one).records("/robot0/swap"))
        for one in (first, second, third)
    ]
    assert [len(one) for one in swaps] == [0, 1, 0]
    if lost is not None:
        (tmp_path / "later" / (second if lost == 1 else first)).unlink()
    whole = join(tmp_path / "later", tmp_path / "whole.mcap").path
    report = replay(whole)
    assert report.verdict == "identical", str(report)
    assert not any("another policy" in note for note in report.notes), report.notes
    ticks = sum(len(list(read_log(one).ticks())) for one in (tmp_path / "later").glob("*.mcap"))
    node = {level.level: level.compared for level in report.levels}["node"]
    assert node >= ticks - 1
    assert set(read_log(whole).attachments) >= {f"policy-{name}.onnx" for name in beside}


def test_what_another_policy_remembers_is_never_carried_over(tmp_path):
    policies = [remembering_policy(seed) for seed in range(3)]
    rng = np.random.default_rng(0)
    pixels = rng.integers(0, 255, (200, *REMEMBERING.retina.shape), np.uint8)
    schedule = {slot: [_retina(slot, pixels[slot - 1])] for slot in range(1, 200)}
    for number, slot in enumerate(range(20, 200, 20)):
        policy = policies[number % 3]
        schedule[slot] = [*schedule[slot], swap_at(slot, policy, while_moving=True)]
    path = tmp_path / "remembering.mcap"
    decided = swapped_drive(path, policies, schedule, 200, shadow=remembering_policy(7))
    start = REMEMBERING.state.start_value
    taken = [now for was, now in pairwise(decided) if was.policy_hash != now.policy_hash]
    assert len(taken) >= 6
    assert all(one.state == pytest.approx(start) for one in taken)
    report = replay(path)
    assert report.verdict == "identical", str(report)


def _retina(slot: int, pixels: np.ndarray) -> Message:
    from reflexarc_runtime.messages.codec import encode_retina

    message = retina_at(slot, np.zeros(CONTRACT.retina.shape, np.uint8))
    payload = encode_retina(pixels, REMEMBERING.retina, message.received_ns)
    return replace(message, payload=payload)


def test_the_summary_says_who_served_and_what_the_shadow_would_have_done(eventful_log):
    path, decided = eventful_log
    summary = summarise(path)
    seen = summary.candidates
    assert seen is not None
    assert set(seen.served) <= {one.policy_hash for one in decided}
    assert len(seen.served) > 10
    assert seen.shadow_hash == policy_hash(exported(HOLDING, seed=9))
    assert seen.compared > 900
    assert 0 < seen.different < seen.compared
