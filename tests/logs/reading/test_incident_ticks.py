"""At which tick something happened: by the body's clock where that is the loop's, too."""

from dataclasses import replace
from pathlib import Path

import pytest

from reflexarc_logs.cutting.incident_part import choose, cut_incident
from reflexarc_logs.judging.flip_limits import FlipLimits
from reflexarc_logs.judging.judge_log import judge_log
from reflexarc_logs.reading.incidents import find_incidents
from reflexarc_logs.reading.reader import Log, read_log
from reflexarc_runtime.policy.policy import load_policy
from support.policies import exported
from support.recordings import CONTRACT, RUN, drive, nominal
from support.staged_incidents import contact, mark, staged

TICKS = 60


def recorded(folder: Path, clock: str, behind: dict[int, int]) -> tuple[Log, dict[int, int]]:
    """A drive with contacts: the tick each stands behind in the file → the tick that led to it.

    Returns:
        The log, and the time of the look of each tick, on the body's clock.
    """
    run = replace(RUN, clock=clock)
    drive(folder / "plain.mcap", exported(CONTRACT, 3), nominal(TICKS), TICKS, run=run)
    plain = read_log(folder / "plain.mcap")
    decisions = [tick.decision for tick in plain.ticks()]
    looks = {one.index: one.input.source_time_ns for one in decisions}
    heard = {place: contact(number) for number, place in enumerate(behind, 1)}
    # A step of the body ends in a contact; with the next look it says so.
    shift_ns = plain.run.publish_shift_ns
    sent_ns = {place: looks[tick + 1] + shift_ns for place, tick in behind.items()}
    heard[50] = mark("here")
    return read_log(staged(folder / "plain.mcap", folder / "drive.mcap", heard, sent_ns)), looks


IN_TIME, LATE, LATER, EARLY = {10: 10}, {21: 20}, {33: 30}, {39: 41}


@pytest.mark.parametrize("behind", [IN_TIME, LATE, LATER, EARLY, {**LATE, **EARLY}])
def test_in_lockstep_a_contact_is_of_the_tick_that_led_to_it(tmp_path: Path, behind):
    log, _ = recorded(tmp_path, "lockstep", behind)
    found = [(one.kind, one.tick) for one in find_incidents(log)]
    assert found == [*(("contact", tick) for tick in behind.values()), ("mark", 50)]


def test_on_another_clock_the_order_of_the_file_counts(tmp_path: Path):
    log, _ = recorded(tmp_path, "monotonic", {**LATE, **EARLY})
    assert [one.tick for one in find_incidents(log)] == [21, 39, 50]


def test_a_contact_whose_time_says_nothing_keeps_its_place(tmp_path: Path):
    """Before all looks, and behind the last one: who forges a time moves nothing."""
    log, _ = recorded(tmp_path, "lockstep", {})
    for sent_ns in (1, 9 * 10**18):
        path = staged(log.path, tmp_path / f"{sent_ns}.mcap", {20: contact()}, {20: sent_ns})
        contacts = [one for one in find_incidents(read_log(path)) if one.kind == "contact"]
        assert [one.tick for one in contacts] == [20]


def test_a_candidate_is_asked_at_that_tick(tmp_path: Path):
    log, looks = recorded(tmp_path, "lockstep", {**LATE, **EARLY})
    candidate = load_policy(exported(CONTRACT, 6), "numpy")
    judged = judge_log(log, candidate, FlipLimits(), "drive")
    ticks = {tick.decision.index: tick.decision for tick in log.ticks()}
    first_ns = ticks[0].now_ns
    assert [(one.tick, one.time_s) for one in judged.incidents] == [
        (tick, (ticks[tick].now_ns - first_ns) / 1e9) for tick in (20, 41, 50)
    ]
    assert looks[20] < looks[21]


@pytest.mark.parametrize("narrow", [True, False])
def test_a_part_holds_the_contact_wherever_it_stands(tmp_path: Path, narrow: bool):
    for name, behind in (("late", LATE), ("later", LATER), ("early", EARLY)):
        (tmp_path / name).mkdir()
        log, _ = recorded(tmp_path / name, "lockstep", behind)
        incident = choose(log, None, "contact")
        found = cut_incident(log, incident, 0.5, tmp_path / f"{name}.mcap", narrow=narrow)
        assert (found.is_shown, found.report.exit_status) == (True, 0)
