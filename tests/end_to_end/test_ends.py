"""Whatever ends a drive, the robot is told to stand in time: the campaign's judge, and a sample."""

import math
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from campaigns.ends.campaign import Campaign, dealt, run
from campaigns.ends.judge import Outcome, judged
from campaigns.ends.kinds import KINDS
from campaigns.ends.lives import marked, waited_ns, zombies
from campaigns.ends.on_bus import told_ms
from campaigns.ends.replays import Replayed
from campaigns.ends.table import summary, table
from campaigns.ends.witness import overslept_ns

MS = 1_000_000
AT_NS = 7_000 * MS
KIND = KINDS[0]


def outcome(said_ms: float, waited_ms: float = 0.0) -> Outcome:
    """A robot that was told to stand so late."""
    return Outcome(KIND.name, 130.0, 0, AT_NS, told_ms=said_ms, waited_ms=waited_ms)


def over(begin_ms: float, end_ms: float) -> tuple[int, int]:
    """A core that did not wake its witness between these moments after the end."""
    return AT_NS + round(begin_ms * MS), AT_NS + round(end_ms * MS)


def test_the_judge_finds_nothing_where_a_bound_was_kept():
    assert judged(outcome(130.0), []) is None


def test_the_judge_reports_a_late_word_and_one_that_never_came():
    for said_ms, over_ms in ((150.0, 20.0), (math.inf, math.inf)):
        judgement = judged(outcome(said_ms), [])
        assert judgement is not None
        assert judgement.over_ms == over_ms
        assert not judgement.is_the_machine_s


@pytest.mark.parametrize(
    ("seen", "excused"),
    [
        ([over(10.0, 31.0)], True),
        ([over(10.0, 29.0)], False),
        ([over(10.0, 21.0), over(40.0, 51.0)], True),
        ([over(10.0, 25.0), over(12.0, 25.0)], False),  # two cores at one time
        ([over(-50.0, 5.0)], False),  # before the end
        ([over(149.0, 300.0)], False),  # after the word
    ],
)
def test_the_judge_excuses_no_more_than_a_witness_overslept_in_that_time(
    seen: list[tuple[int, int]], excused: bool
):
    judgement = judged(outcome(150.0), seen)
    assert judgement is not None
    assert judgement.is_the_machine_s is excused
    never = judged(outcome(math.inf), seen)
    assert never is not None
    assert not never.is_the_machine_s


@pytest.mark.parametrize(("waited_ms", "excused"), [(19.0, False), (21.0, True)])
def test_the_judge_takes_the_kernel_s_account_as_evidence(waited_ms: float, excused: bool):
    judgement = judged(outcome(150.0, waited_ms), [])
    assert judgement is not None
    assert judgement.is_the_machine_s is excused


def test_the_judge_reports_a_robot_that_was_told_in_time_and_does_not_stand():
    late = outcome(100.0)
    late.stand_ms = {"holds": 130.0 + 500.0 + 31.0}
    judgement = judged(late, [])
    assert judgement is not None
    assert judgement.over_ms == pytest.approx(1.0)


def test_oversleeps_are_added_up_once_where_cores_overslept_together():
    assert overslept_ns([(0, 10), (5, 20), (30, 40), (90, 200)], 2, 100) == 18 + 10 + 10


def test_the_word_that_counts_is_the_first_that_nothing_followed():
    words = [(1 * MS, False), (2 * MS, True), (3 * MS, False), (4 * MS, True), (5 * MS, True)]
    assert told_ms(words, 0, first=True) == 2.0
    assert told_ms(words, 0, first=False) == 4.0
    assert told_ms(words[:3], 0, first=False) == math.inf


def test_a_late_word_and_a_log_that_does_not_replay_fail_a_campaign():
    seen = Campaign([outcome(150.0)], [Replayed("a.mcap", False, "replay differs")])
    report = summary(seen)
    assert len(report["failures"]) == 2
    assert "FAILED" in table(report)
    excused = summary(Campaign([outcome(150.0)], [], [over(10.0, 40.0)]))
    assert excused["failures"] == []
    assert excused["kinds"][KIND.name]["the machine's"] == 1


def test_an_empty_log_is_excused_only_in_the_first_second_of_its_runtime():
    for lived_ms, failures in ((900.0, 0), (1100.0, 1)):
        young = outcome(100.0)
        young.log, young.lived_ms = "a.mcap", lived_ms
        empty = Replayed("a.mcap", True, "a.mcap: no tick", is_empty=True)
        assert len(summary(Campaign([young], [empty]))["failures"]) == failures


def test_every_kind_comes_up_in_its_turn_and_the_seed_decides_the_rest(tmp_path: Path):
    def ends(seed: int) -> list[tuple[int, int]]:
        return sorted(
            end for shift in dealt(2 * len(KINDS), seed, "", tmp_path) for end in shift.ends
        )

    assert [number for number, _ in ends(3)] == sorted([*range(len(KINDS))] * 2)
    assert ends(3) == ends(3)
    assert ends(3) != ends(4)


def test_an_unburied_child_and_one_left_behind_are_found():
    mark = f"{time.time_ns()}"
    words = [sys.executable, "-c", "import time; time.sleep(30)"]
    child = subprocess.Popen(words, env={**os.environ, "REFLEXARC_ENDS": mark})
    while marked(mark) != [child.pid]:
        time.sleep(0.01)
    assert child.pid not in zombies([os.getpid()])
    child.kill()
    while child.pid not in zombies([os.getpid()]):
        time.sleep(0.01)
    child.wait()
    assert zombies([os.getpid()]) == marked(mark) == []


def test_the_kernel_says_how_long_somebody_waited_for_a_core():
    core = {min(os.sched_getaffinity(0))}
    spin = f"import os\nos.sched_setaffinity(0, {core})\nwhile True: pass"
    both = [subprocess.Popen([sys.executable, "-c", spin]) for _ in range(2)]
    try:
        end_s = time.monotonic() + 30.0
        while waited_ns([both[0].pid]) < 50 * MS:  # one of two on one core waits half the time
            assert time.monotonic() < end_s
            time.sleep(0.05)
    finally:
        for process in both:
            process.kill()
            process.wait()


@pytest.mark.long
@pytest.mark.parametrize("only", ["bus, runtime: SIGKILL", "ros2, bridge: SIGSTOP"])
def test_a_sample_of_real_ends(tmp_path: Path, only: str):
    report = summary(run(ends=2, seed=7, parallel=1, only=only, folder=tmp_path))
    assert report["failures"] == []
    assert report["ends"] == 2
    assert report["replayed"] + report["empty"] == report["logs"] >= 1
