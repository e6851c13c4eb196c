from typing import Any

import pytest

from reflexarc_runtime.messages.wire import Message
from reflexarc_runtime.ros2.laser_scan import RosScanner
from reflexarc_runtime.sensing.range_meaning import RangeMeaning
from reflexarc_sim_bridge.body.ros2.scan_relay import ScanRelay
from reflexarc_sim_bridge.body.ros2.stamps import ScanStamps
from support.ros2 import Time, laser_scan
from support.spoken import Spoken

SECOND_NS = 1_000_000_000


def message(payload: bytes, received_ns: int = 0) -> Message:
    return Message("scan", payload, "", b"", received_ns)


def test_scans_leave_with_the_time_of_their_arrival():
    spoken: Any = Spoken()
    scans = ScanRelay(spoken, ScanStamps())
    scans.hear(message(laser_scan([1.0, 2.0]).serialize(), received_ns=123))
    assert [time_ns for _, time_ns in spoken.said] == [123]
    assert scans.scans == 1


def test_the_stamp_of_a_scan_is_found_by_the_time_of_its_arrival():
    spoken: Any = Spoken()
    stamps = ScanStamps()
    scans = ScanRelay(spoken, stamps)
    scans.hear(message(laser_scan([1.0, 2.0], stamp=Time(5, 6)).serialize(), received_ns=123))
    assert stamps.at(123) == 5_000_000_006


def test_what_is_no_scan_is_counted_by_reason_and_said_once(caplog: pytest.LogCaptureFixture):
    spoken: Any = Spoken()
    scans = ScanRelay(spoken, ScanStamps())
    for payload in (b"noise", b"more noise", laser_scan([]).serialize()):
        scans.hear(message(payload))
    assert spoken.said == []
    assert scans.refused == {"no little-endian CDR": 2, "fewer than 2 or more than 16384 beams": 1}
    assert [record.levelname for record in caplog.records] == ["WARNING", "WARNING"]


def test_reasons_that_differ_in_their_numbers_are_one_and_said_again_after_a_good_while(
    caplog: pytest.LogCaptureFixture,
):
    spoken: Any = Spoken()
    scans = ScanRelay(spoken, ScanStamps(), RosScanner(RangeMeaning(max_m=3.0)))
    for second in range(40):
        far = laser_scan([1.0, 4.0 + 0.1 * second]).serialize()
        scans.hear(message(far, received_ns=second * SECOND_NS))
    assert list(scans.refused.values()) == [40]
    assert len(caplog.records) == 1
    assert "a range of 4 m, beyond --range-max 3" in caplog.text
    scans.hear(message(far, received_ns=200 * SECOND_NS))
    assert len(caplog.records) == 2
    assert len(scans.refused) == 1


def taken_ms(arrivals_ms: list[int], stamps_ms: list[int], **options: bool) -> list[int]:
    """The times with which scans leave."""
    spoken: Any = Spoken()
    scans = ScanRelay(spoken, ScanStamps(), **options)
    for arrived_ms, stamp_ms in zip(arrivals_ms, stamps_ms, strict=True):
        stamp = Time(stamp_ms // 1000, stamp_ms % 1000 * 1_000_000)
        payload = laser_scan([1.0, 2.0], stamp=stamp).serialize()
        scans.hear(message(payload, received_ns=arrived_ms * 1_000_000))
    return [time_ns // 1_000_000 for _, time_ns in spoken.said]


def test_scans_out_of_a_queue_leave_with_the_time_at_which_they_were_taken():
    stamps = [90_000, 90_100, 90_200, 90_300]  # on a clock of their own
    assert taken_ms([5_000, 5_100, 7_200, 7_200], stamps) == [5_000, 5_100, 5_200, 5_300]


def test_scans_without_a_stamp_leave_with_their_arrival():
    assert taken_ms([5_000, 5_100, 7_200], [0, 0, 0]) == [5_000, 5_100, 7_200]


def test_a_stamp_that_never_changes_is_one_scan_again_and_again():
    assert taken_ms([5_000, 5_100, 7_200], [9, 9, 9]) == [5_000, 5_000, 5_000]


def test_a_clock_that_steps_makes_no_scan_younger_nor_much_older():
    arrivals = [5_000 + 100 * number for number in range(6)]
    for step_ms in (-3_000, 3_000):
        stamps = [90_000 + 100 * n + step_ms * (n >= 3) for n in range(6)]
        assert taken_ms(arrivals, stamps) == [5_000, 5_100, 5_200, 5_200, 5_300, 5_400]


def test_the_stamps_of_a_slow_simulator_can_be_left_out():
    arrivals, stamps = [5_000, 5_100, 5_200], [1_000, 1_050, 1_100]
    assert taken_ms(arrivals, stamps) == [5_000, 5_050, 5_100]
    assert taken_ms(arrivals, stamps, heeds_stamps=False) == arrivals
