"""What a sense is told goes into the log and comes back; scans with hardly any return."""

import json
import math

import pytest
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan

from reflexarc_runtime.errors import LogError, UsageError
from reflexarc_runtime.sensing.scan import UnusableScanError
from reflexarc_runtime.sensing.scan_reading import read_scan
from reflexarc_runtime.sensing.sense_settings import SenseSettings

ASKED = SenseSettings(frozen_after_s=2.0, least_returns=0.25)


def test_settings_come_back_from_a_log():
    assert SenseSettings.from_json(ASKED.to_json()) == ASKED


def test_a_log_of_before_asked_for_nothing_of_it():
    document = json.loads(ASKED.to_json())
    del document["frozen_after_s"], document["least_returns"]
    assert SenseSettings.from_json(json.dumps(document)) == SenseSettings()
    del document["mount"]
    with pytest.raises(LogError, match="mount"):
        SenseSettings.from_json(json.dumps(document))


@pytest.mark.parametrize(
    ("settings", "flag"),
    [
        ({"frozen_after_s": 0.0}, "--frozen-after"),
        ({"frozen_after_s": math.nan}, "--frozen-after"),
        ({"frozen_after_s": math.inf}, "--frozen-after"),
        ({"least_returns": 0.0}, "--least-returns"),
        ({"least_returns": 1.1}, "--least-returns"),
        ({"least_returns": math.nan}, "--least-returns"),
    ],
)
def test_absurd_settings_are_refused_by_the_flag_s_name(settings, flag):
    with pytest.raises(UsageError, match=flag):
        SenseSettings(**settings)


@pytest.mark.parametrize(
    ("ranges", "is_used"),
    [
        ([1.0, 2.0] + [math.inf] * 6, True),  # 2 of 8: the share itself
        ([1.0] + [math.inf] * 7, False),
        ([-math.inf] * 8, False),  # a hand in front of it
        ([0.0] * 8, False),
        ([math.nan] * 7 + [1.0], False),
        ([1.0] * 8, True),
    ],
)
def test_a_scan_with_hardly_any_return_is_refused(ranges: list[float], is_used: bool):
    scan = LaserScan(start_angle=-1.0, end_angle=1.0, ranges=ranges)
    read_scan(scan, SenseSettings())
    if is_used:
        read_scan(scan, ASKED)
        return
    with pytest.raises(UnusableScanError, match=r"--least-returns.*covered, or broken"):
        read_scan(scan, ASKED)
