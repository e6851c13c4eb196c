from typing import Any

import pytest

from reflexarc_runtime.messages.wire import Message
from reflexarc_runtime.sensing.range_meaning import RangeMeaning
from reflexarc_sim_bridge.body.ros2.messages import RosScanner
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
    assert scans.refused == {"no little-endian CDR": 2, "fewer than 2 or more than 100000 beams": 1}
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
