"""What is said of incidents that were driven again, word for word."""

from dataclasses import replace
from pathlib import Path

import pytest

from reflexarc.rebuilding.driven_findings import DrivenLog, Tried, WantedDrives
from reflexarc.rebuilding.driven_report import DrivenReport, drive_logs, incident_line
from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.body.body import BodyPose
from reflexarc_sim_bridge.body.driving_on import DrivenWay

HERE = (BodyPose(0.0, 0.0),)
TOUCHES = DrivenWay(HERE, 32, 0.0, 0.66, {})
FREE = DrivenWay(HERE, None, 0.214, 5.02, {})
AGAIN = Tried(33, True, 0.66, 5.0, TOUCHES, FREE, 33, None, None, 0.0)


def test_an_avoided_contact_reads_so():
    assert incident_line(AGAIN, "new.onnx") == (
        "contact at tick 33: recorded policy touches at tick 33 again; new.onnx avoids it "
        "(nearest 0.21 m, 5.0 m driven within 5 s); from 0.66 s before"
    )


@pytest.mark.parametrize(
    ("tick", "words"),
    [
        (33, "touches at tick 33 as well"),
        (30, "touches at tick 30"),
        (40, "gets past it and touches at tick 40"),
    ],
)
def test_a_contact_that_is_not_avoided_reads_so(tick: int, words: str):
    one = replace(AGAIN, candidate=TOUCHES, candidate_tick=tick)
    assert f"; a\\x1b.onnx {words}; from" in incident_line(one, "a\x1b.onnx")


def test_who_stands_because_its_policy_failed_is_seen_to():
    stands = replace(FREE, driven_m=0.0, not_asked={"POLICY_FAULT": 249, "RECOVERING": 1})
    line = incident_line(replace(AGAIN, candidate=stands), "new.onnx")
    assert "0.0 m driven within 5 s, its policy not asked at 250 ticks" in line


def test_a_control_that_leaves_the_recorded_way_says_from_where_on():
    one = replace(AGAIN, recorded=FREE, recorded_tick=None, leaves_tick=20, leaves_m=0.04)
    line = incident_line(one, "new.onnx")
    assert "recorded policy touches nothing (nearest 0.21 m" in line
    assert "leaves its recorded way at tick 20, 0.04 m at most" in line


def report(*logs: DrivenLog) -> DrivenReport:
    return DrivenReport("new.onnx", logs)


def test_the_exit_status_is_0_if_all_are_avoided_1_if_not_and_2_if_nothing_was_tried():
    good = DrivenLog(Path("a"), tried=(AGAIN, AGAIN))
    bad = DrivenLog(Path("b"), tried=(AGAIN, replace(AGAIN, candidate_tick=33)))
    empty, broken = DrivenLog(Path("c")), DrivenLog(Path("d"), problem="d: no world")
    assert report(good).exit_status == 0
    assert report(good, empty).exit_status == 0
    assert report(good, bad).exit_status == 1
    assert report(empty).exit_status == 2
    assert report(good, broken).exit_status == 2
    assert report(broken).lines() == ["d: cannot be rebuilt: no world"]
    assert report(good).lines()[-1] == "  new.onnx touches nothing at 2 of 2"


def test_a_log_without_a_world_says_that_it_has_none():
    golden = Path("tests/golden/nominal.mcap")
    found = drive_logs((golden, Path("missing.mcap")), None, WantedDrives())
    assert found.exit_status == 2
    assert all(log.problem for log in found.logs)
    assert [log["log"] for log in found.as_dict()["logs"]] == [str(golden), "missing.mcap"]


def test_what_cannot_be_wanted_is_refused():
    for wrong in ({"before_s": 0.0}, {"driven_s": float("nan")}, {"at": 3, "first": True}):
        with pytest.raises(UsageError):
            WantedDrives(**wrong)  # type: ignore[arg-type]  # wrong on purpose
