import math

import numpy as np
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_logs.lidar_messages import LidarMessages
from reflexarc_logs.sweep import Distances, Sweep

ANY_FLOATS = st.lists(st.floats(allow_nan=True, allow_infinity=True), min_size=1, max_size=300)
TIMES_NS = st.none() | st.integers(-(10**18), 10**18)


def by_protobuf(ranges: list[float], time_ns: int | None) -> bytes:
    """The same scan, every field given to protobuf."""
    scan = LaserScan(frame_id="robot0", start_angle=-1.5, end_angle=1.5, ranges=ranges)
    scan.pose.orientation.w = 1.0
    scan.timestamp.seconds, scan.timestamp.nanos = divmod(time_ns or 0, 10**9)
    return scan.SerializeToString()


@given(ANY_FLOATS, TIMES_NS)
def test_a_scan_has_the_very_bytes_that_protobuf_makes(ranges: list[float], time_ns: int | None):
    sweep = Sweep(time_ns, -1.5, 1.5, np.array(ranges))
    assert LidarMessages("robot0").scan(sweep) == by_protobuf(ranges, time_ns)


def test_the_length_of_the_longest_scans_takes_more_than_two_bytes():
    ranges = [1.0 / k for k in range(1, 65_537)]
    sweep = Sweep(0, -1.5, 1.5, np.array(ranges))
    assert LidarMessages("robot0").scan(sweep) == by_protobuf(ranges, 0)


@given(st.lists(st.floats(), min_size=1, max_size=50))
def test_words_become_the_numbers_that_python_reads_in_them(numbers: list[float]):
    words = [repr(number).encode() for number in numbers]
    found = Distances(float).of(words)
    assert found.tobytes() == np.array([float(w) for w in words], "<f8").tobytes()


def test_a_word_that_is_no_number_is_unknown_each_time_that_it_comes():
    distances = Distances(float)
    assert all(map(math.isnan, distances.of([b"x", b"x"])))
    assert distances.unreadable == 2
