from reflexarc_logs.reading.stream_clock import StreamClock

WALL_NS = 1_700_000_000_000_000_000
OFFSET_NS = WALL_NS - 5_000_000_000
MS = 1_000_000


def test_a_stamp_on_the_monotonic_clock_is_shifted_by_the_offset():
    clock = StreamClock(OFFSET_NS)
    assert clock.wall_ns(5_000_000_000, WALL_NS + MS) == WALL_NS


def test_a_stamp_on_a_wall_clock_is_left_as_it_is():
    clock = StreamClock(OFFSET_NS)
    assert clock.wall_ns(WALL_NS - MS, WALL_NS) == WALL_NS - MS


def test_a_stamp_of_a_clock_that_nobody_knows_gives_way_to_the_arrival():
    clock = StreamClock(OFFSET_NS)
    assert clock.wall_ns(976_000_000_000_000_000, WALL_NS) == WALL_NS


def test_in_lockstep_both_clocks_are_one():
    assert StreamClock(0).wall_ns(7 * MS, 8 * MS) == 7 * MS


def test_a_stream_never_changes_its_clock():
    """A message that hung in a queue for minutes is late; it is not of another clock."""
    clock = StreamClock(OFFSET_NS)
    clock.wall_ns(5_000_000_000, WALL_NS)
    assert clock.wall_ns(6_000_000_000, WALL_NS + 300_000_000_000) == WALL_NS + 1_000_000_000
