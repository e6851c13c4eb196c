"""Who decided where, as a log's ticks say."""

from reflexarc.rebuilding.recorded_drive import RecordedDrive, ToldThere
from reflexarc_runtime.messages.body_info import BodyInfo
from reflexarc_sim_bridge.body.ride import HandOver


def drive(*decided: tuple[int, str, bool]) -> RecordedDrive:
    """One tick for each (time of its look, policy, whether it began anew)."""
    told = {
        time_ns: ToldThere(tick, time_ns + 7, 0, None, name, anew)
        for tick, (time_ns, name, anew) in enumerate(decided)
    }
    return RecordedDrive(BodyInfo("plane", "", 0, 0, 0.02), is_lockstep=False, told=told)


def test_a_log_of_one_policy_has_no_turns():
    assert drive((1, "a", False), (2, "a", False)).hand_overs("a") == []


def test_each_change_of_hands_is_a_turn_and_so_is_a_part_that_begins_behind_one():
    decided = (10, "b", False), (20, "b", False), (30, "c", False), (40, "b", False)
    assert drive(*decided).hand_overs("a") == [
        HandOver(10, "b", "a"),
        HandOver(30, "c", "b"),
        HandOver(40, "b", "c"),
    ]


def test_a_roll_back_within_one_tick_begins_anew_and_leaves_nobody_to_go_back_to():
    decided = (10, "a", False), (20, "a", True), (30, "a", False)
    assert drive(*decided).hand_overs("a") == [HandOver(20, "a", "")]


def test_ticks_count_in_their_own_order_whatever_the_order_of_the_looks():
    told = drive((20, "a", False), (10, "b", False)).hand_overs("a")
    assert told == [HandOver(10, "b", "a")]
