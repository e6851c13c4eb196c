from reflexarc.doctoring.cyclictest import MOST_US, parse_histogram

SAID = """# /dev/cpu_dma_latency set to 0us
# Histogram
000000 000000
000010 000500
000020 000489
000030 000010
000900 000001
# Min Latencies: 00010
# Avg Latencies: 00015
# Max Latencies: 00900
# Histogram Overflows: 00000
# Histogram Overflow at cycle number:
# Thread 0:
"""


def test_a_histogram_is_read_as_its_percentiles():
    found = parse_histogram(SAID)
    assert found is not None
    times_us = sorted([10] * 500 + [20] * 489 + [30] * 10 + [900])
    expected = [1000 * times_us[at - 1] for at in (500, 990, 999, 1000)]  # the nearest rank
    assert [found.p50_ns, found.p99_ns, found.p999_ns, found.max_ns] == expected
    assert found.count == 1000


def test_what_was_later_than_the_histogram_counts_as_its_end():
    found = parse_histogram(SAID.replace("Overflows: 00000", "Overflows: 00020"))
    assert found is not None
    assert (found.count, found.max_ns, found.p99_ns) == (1020, 1000 * MOST_US, 1000 * MOST_US)


def test_what_says_nothing_is_none():
    assert parse_histogram("") is None
    assert parse_histogram("Unable to change scheduling policy!\n") is None
