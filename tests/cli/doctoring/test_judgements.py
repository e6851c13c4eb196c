"""What follows from what was found on a machine; the figures are made up, the verdicts by hand."""

from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from reflexarc.doctoring.bus_rows import judge_brains, port_is_open
from reflexarc.doctoring.certificates import check_certificates, judge_dates, judge_mode
from reflexarc.doctoring.check_row import Health
from reflexarc.doctoring.disk import check_disk, judge_kind, judge_room, judge_speed, kind_of
from reflexarc.doctoring.kernel_and_clock import (
    judge_resolution,
    judge_source,
    judge_swap,
    judge_waits,
    judge_wall_clock,
)
from reflexarc.doctoring.lateness_rows import judge_waking, lateness_rows
from reflexarc.doctoring.lateness_trial import NoPunctuality, Punctuality
from reflexarc.doctoring.machine_files import fields_of, number_of, text_of
from reflexarc.doctoring.processors import (
    judge_governor,
    judge_quota,
    judge_steal,
    parse_stolen,
    stolen_share,
)
from reflexarc.doctoring.promise import judge_promise, promise_of
from reflexarc.doctoring.rights import judge_grant, judge_locked, judge_throttling
from reflexarc_runtime.loop.realtime.grant import Grant
from reflexarc_runtime.messages.spread import Spread

WELL, MIND, BAD, UNKNOWN = Health.WELL, Health.MIND, Health.BAD, Health.UNKNOWN
NOW = datetime(2026, 5, 1, tzinfo=UTC)
DAY = timedelta(days=1)


def spread(p999_us: int, p99_us: int = 0) -> Spread:
    return Spread(1000, 0, 1000 * p99_us, 1000 * p999_us, 1000 * p999_us)


def punctual(scheduling: str, late_us: int, tick_us: int = 200, record_us: int = 20) -> Punctuality:
    return Punctuality(scheduling, spread(late_us), spread(tick_us), spread(record_us))


@pytest.mark.parametrize(
    ("row", "health"),
    [
        (judge_quota(None), WELL),
        (judge_quota("max 100000"), WELL),
        (judge_quota("-1 100000"), WELL),
        (judge_quota("50000 100000"), MIND),
        (judge_quota("nonsense 0"), UNKNOWN),
        (judge_quota("50000"), UNKNOWN),
        (judge_governor(None), WELL),
        (judge_governor("performance"), WELL),
        (judge_governor("powersave"), MIND),
        (judge_steal(None), UNKNOWN),
        (judge_steal(0.001), WELL),
        (judge_steal(0.1), MIND),
        (judge_throttling(None, None), UNKNOWN),
        (judge_throttling(950000, 1000000), WELL),
        (judge_throttling(0, 1000000), MIND),
        (judge_throttling(-1, 1000000), MIND),
        (judge_locked(-1), WELL),
        (judge_locked(65536), WELL),
        (judge_grant(Grant("SCHED_FIFO 80", "SCHED_FIFO 80")), WELL),
        (judge_grant(Grant("SCHED_FIFO 80", "", "not permitted", "ulimit -r 80")), MIND),
        (judge_resolution(1e-9), WELL),
        (judge_resolution(4e-3), BAD),
        (judge_source("tsc"), WELL),
        (judge_source("hpet"), MIND),
        (judge_source(None), UNKNOWN),
        (judge_wall_clock(0), WELL),
        (judge_wall_clock(5), MIND),
        (judge_wall_clock(None), UNKNOWN),
        (judge_waits(is_steady=True), WELL),
        (judge_waits(is_steady=False), MIND),
        (judge_swap({}), UNKNOWN),
        (judge_swap({"SwapTotal": "0 kB"}), WELL),
        (judge_swap({"SwapTotal": "1000 kB"}), MIND),
        (judge_room(2000.0), WELL),
        (judge_room(10.0), MIND),
        (judge_kind("ext4"), WELL),
        (judge_kind("nfs4"), MIND),
        (judge_kind("tmpfs"), MIND),
        (judge_kind(None), UNKNOWN),
        (judge_speed(100.0, 0.01), WELL),
        (judge_speed(1.0, 0.01), MIND),
        (judge_speed(100.0, 2.0), MIND),
        (judge_brains("robot0", brain=False, body=True), WELL),
        (judge_brains("robot0", brain=True, body=True), BAD),
        (judge_mode(0o100600), WELL),
        (judge_mode(0o100640), MIND),
        (judge_dates("body", NOW - DAY, NOW + 90 * DAY, NOW), WELL),
        (judge_dates("body", NOW - DAY, NOW + 3 * DAY, NOW), MIND),
        (judge_dates("body", NOW - DAY, NOW, NOW), BAD),
        (judge_dates("body", NOW + DAY, NOW + 9 * DAY, NOW), BAD),
    ],
)
def test_what_was_found_is_judged(row, health):
    assert row.health is health
    assert row.found
    assert (row.health is WELL) == (not row.why)


def test_a_rate_is_what_the_parts_of_a_period_leave():
    # 1.25 × (380 + 200 + 20 + 100) µs = 875 µs
    assert promise_of(punctual("ordinary", 380)).rate_hz == pytest.approx(1e6 / 875)
    assert promise_of(punctual("ordinary", 3680)).rate_hz == pytest.approx(200.0)


def test_no_rate_is_promised_beyond_what_was_tried():
    found = [Punctuality("ordinary", spread(1), None, None)]
    assert "ordinary 1000 Hz" in judge_promise(found, 50.0, "the rate").found
    assert "ordinary 2000 Hz" in judge_promise(found, 2000.0, "the rate").found


@pytest.mark.parametrize(
    ("ordinary_us", "fifo_us", "health", "words"),
    [
        (3680, 380, WELL, "ordinary 200 Hz"),
        (20_000, 3680, MIND, "only with a priority: SCHED_FIFO 80"),
        (40_000, 30_000, BAD, "most of it is the lateness"),
    ],
)
def test_the_contracts_rate_decides(ordinary_us, fifo_us, health, words):
    found = [punctual("ordinary", ordinary_us), punctual("SCHED_FIFO 80", fifo_us)]
    row = judge_promise(found, 50.0, "the contract's")
    assert row.health is health
    assert words in row.found + row.why


def test_a_slow_policy_is_named_as_the_cause():
    row = judge_promise([punctual("ordinary", 100, tick_us=30_000)], 50.0, "the contract's")
    assert (row.health, row.remedy.split(",")[0]) == (BAD, "a smaller network")


def test_where_nothing_was_measured_nothing_is_promised():
    row = judge_promise([NoPunctuality("ordinary", "it hangs")], 50.0, "the rate")
    assert (row.health, row.why) == (BAD, "it hangs")
    assert [row.health for row in lateness_rows(NoPunctuality("ordinary", "it hangs"))] == [UNKNOWN]


@pytest.mark.parametrize(("own_us", "health"), [(60, WELL), (69, WELL), (71, MIND)])
def test_waking_is_compared_with_what_c_gets(own_us, health):
    beside = spread(0, p99_us=20)
    found = Punctuality("ordinary", spread(0, p99_us=own_us), None, None, 0, beside, "C")
    assert judge_waking("waking", found).health is health


TCP = """  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid
   0: 0100007F:1D17 00000000:0000 0A 00000000:00000000 00:00000000 00000000     0        0 1
   1: 0100007F:1D18 0100007F:1D17 01 00000000:00000000 00:00000000 00000000     0        0 2
   2: 00000000:1D19 00000000:0000 0A 00000000:00000000 00:00000000 00000000     0        0 3
   3: 0A00000A:1D1A 00000000:0000 0A 00000000:00000000 00:00000000 00000000     0        0 4
broken
"""


@pytest.mark.parametrize(
    ("port", "is_open"), [(7447, True), (7448, False), (7449, True), (7450, False), (7451, False)]
)
def test_who_listens_stands_in_the_kernels_table(port, is_open):
    assert port_is_open(TCP, port) is is_open


def test_the_longest_mount_point_names_the_file_system():
    mounts = "/dev/a / ext4 rw 0 0\ntmpfs /tmp tmpfs rw 0 0\nnas:/x /srv/my\\040logs nfs4 rw 0 0\nx"
    assert kind_of(Path("/home"), mounts) == "ext4"
    assert kind_of(Path("/tmp/a"), mounts) == "tmpfs"
    assert kind_of(Path("/srv/my logs/a"), mounts) == "nfs4"
    assert kind_of(Path("/home"), "") is None


def test_the_first_line_of_stat_tells_what_was_stolen():
    assert parse_stolen("cpu  1 2 3 4 5 6 7 8 9 10") == (8, 36)
    assert parse_stolen("cpu  1 2 3") is None
    assert parse_stolen("") is None
    assert stolen_share((8, 100), (10, 200)) == pytest.approx(0.02)
    assert stolen_share((8, 100), (8, 100)) is None
    assert stolen_share(None, (8, 100)) is None


def test_what_cannot_be_read_is_none(tmp_path: Path):
    assert text_of(tmp_path / "absent") is None
    assert number_of(tmp_path) is None
    assert fields_of(tmp_path / "absent") == {}


def test_a_disk_is_tried_and_nothing_is_left(tmp_path: Path):
    rows = list(check_disk(tmp_path))
    assert [row.name for row in rows] == ["disk room", "file system", "disk speed"]
    assert list(tmp_path.iterdir()) == []
    assert [row.health for row in check_disk(tmp_path / "absent")] == [BAD]


def test_a_configuration_that_is_not_there_is_a_row(tmp_path: Path):
    assert [row.health for row in check_certificates(tmp_path / "absent.json5")] == [UNKNOWN]
