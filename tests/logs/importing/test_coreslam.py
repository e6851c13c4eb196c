import math
from pathlib import Path

import numpy as np
import pytest
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan

from reflexarc_logs.container.rejected import accepted_message
from reflexarc_logs.importing.lidar_import import ImportReport, import_log
from reflexarc_logs.reading.reader import Log, read_log
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.controller import Controller
from reflexarc_runtime.decision import Verdict
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.loop.clock import ManualClock
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.node import Node
from reflexarc_runtime.loop.outlets import Outlets
from reflexarc_runtime.loop.pacing.rate_pacer import RatePacer
from reflexarc_runtime.messages.wire import Message, Stamp
from reflexarc_runtime.messages_pb2 import Tick
from reflexarc_runtime.policy.policy import load_policy
from reflexarc_runtime.sensing.senses import ScanSense
from support.lidar import coreslam, coreslam_file, slow_coreslam
from support.policies import exported

PERIOD_NS = 20_000_000
LIMIT_S = 0.12


def imported(folder: Path, text: str, **wishes: object) -> tuple[ImportReport, Log]:
    source, out = folder / "in.dat", folder / "out.mcap"
    source.write_text(text)
    said = import_log(source, out, "coreslam", **wishes)  # type: ignore[arg-type]  # as given
    return said, read_log(out)


def scans(log: Log) -> list[LaserScan]:
    return [scan for _, scan in log.messages("/robot0/scan", LaserScan)]


def test_millimetres_become_metres_over_240_degrees(tmp_path: Path):
    ranges = list(range(1000, 1682))
    _, log = imported(tmp_path, coreslam(ranges))
    (scan,) = scans(log)
    assert list(scan.ranges)[70:612] == [r / 1000 for r in ranges[70:612]]
    assert (scan.start_angle, scan.end_angle) == pytest.approx(
        (-2 * math.pi / 3, 2 * math.pi / 3), abs=1e-15
    )
    assert {record.topic for record in log.records()} == {"/robot0/scan"}


def test_the_outer_70_beams_on_each_side_are_unknown_whatever_they_give(tmp_path: Path):
    said, log = imported(tmp_path, coreslam([500] * 682))
    known = [not math.isnan(r) for r in scans(log)[0].ranges]
    assert known == [False] * 70 + [True] * 542 + [False] * 70
    assert said.unknown == {"blind": 140}


def test_zero_is_no_return_and_error_codes_are_unknown(tmp_path: Path):
    middle = [0, 1, 6, 19, "2.5", 20, 5600, -5, "x", "1_000", "nan", "1e999"]
    said, log = imported(tmp_path, coreslam([0] * 70 + middle + [300] * 530 + [0] * 70))
    seen = list(scans(log)[0].ranges)[70:82]
    assert seen[0] == math.inf
    assert seen[5:7] == [0.02, 5.6]
    assert all(map(math.isnan, seen[1:5] + seen[7:]))
    assert said.no_return == 1
    assert said.unknown == {"error code": 7, "no number": 2, "blind": 140}


def test_decimals_behind_every_number_change_nothing(tmp_path: Path):
    ranges = [0, 6, *range(300, 980)]
    (plain,) = scans(imported(tmp_path, coreslam(ranges, 1_234_567))[1])
    (tmp_path / "out.mcap").unlink()
    decimals = " ".join(f"{word}.0" for word in coreslam(ranges, 1_234_567).split()) + "\n"
    (scan,) = scans(imported(tmp_path, decimals)[1])
    assert scan.SerializeToString() == plain.SerializeToString()


@pytest.mark.parametrize("time", ["1e999999999", "nan", "1_0", "1,5", "0e99999999999999999999"])
def test_a_time_that_is_no_number_breaks_its_line_alone(tmp_path: Path, time: str):
    said, _ = imported(tmp_path, coreslam([300] * 682, time) + coreslam([300] * 682))
    assert (said.scans, sum(said.broken_lines.values())) == (1, 1)


def test_a_file_of_which_no_beam_is_known_is_refused(tmp_path: Path):
    with pytest.raises(LogError, match=r"no beam of its 2 scans .*\(1084 no number, 280 blind\)"):
        imported(tmp_path, coreslam(["x"] * 682) * 2)
    assert not list(tmp_path.glob("out*"))


def test_broken_lines_are_counted_by_kind(tmp_path: Path):
    good = coreslam([300] * 682)
    lines = [
        good,
        coreslam(["x"] * 682, "soon"),
        coreslam([300] * 681, tail="\n"),
        coreslam([300] * 684),
        coreslam([300] * 682, "soon"),
        "\n",
        coreslam([300] * 682, tail="\n"),
        coreslam([300] * 681 + [3], tail=""),  # was it 3 or 300?
    ]
    said, _ = imported(tmp_path, "".join(lines))
    assert said.scans == 2
    assert said.broken_lines == {
        "wrong count of numbers": 2,
        "a pose or a time is no number": 2,
        "cut off at the end of the file": 1,
    }
    assert said.first_broken_line == 2
    assert said.unknown == {"blind": 280}


def test_wheel_counts_are_read_counted_and_not_made_odometry(tmp_path: Path):
    said, _ = imported(tmp_path, coreslam([300] * 682) * 3)
    assert (said.odometry, said.poses) == (0, 0)
    assert "3 pairs of wheel encoder counts" in said.notes[0]


def test_a_time_beyond_every_calendar_is_left_out(tmp_path: Path):
    said, _ = imported(tmp_path, coreslam([300] * 682, 10**30))
    assert said.times_left_out == 1


def test_another_format_is_refused_and_leaves_nothing(tmp_path: Path):
    with pytest.raises(LogError, match="expected a coreslam log"):
        imported(tmp_path, "FLASER 2 1 2 1 2 3 1 2 3 4 host 4\n")
    assert not list(tmp_path.glob("out*"))


def test_the_real_log_is_imported_to_the_letter_with_its_own_times(tmp_path: Path):
    said = import_log(coreslam_file(), tmp_path / "out.mcap", "coreslam", rate="recorded")
    log = read_log(tmp_path / "out.mcap")
    times_us, numbers = slow_coreslam(coreslam_file())
    expected = np.where(numbers == 0, np.inf, np.where(numbers < 20, np.nan, numbers / 1000))
    expected[:, :70] = expected[:, -70:] = np.nan
    np.testing.assert_array_equal([list(scan.ranges) for scan in scans(log)], expected)
    records = list(log.records("/robot0/scan"))
    assert [r.log_ns for r in records] == ((times_us - times_us[0]) * 1000).tolist()
    assert [s.timestamp.ToNanoseconds() for s in scans(log)] == (times_us * 1000).tolist()
    inner = numbers[:, 70:-70]
    assert said.no_return == (inner == 0).sum()
    assert said.unknown["error code"] == ((inner > 0) & (inner < 20)).sum()


class FileClock(ManualClock):
    """Sleeping delivers what the file says has arrived meanwhile."""

    def __init__(self, inbox: Inbox, messages: list[Message]) -> None:
        super().__init__()
        self._inbox, self._messages = inbox, messages

    def sleep_until_ns(self, deadline_ns: int) -> None:
        super().sleep_until_ns(deadline_ns)
        while self._messages and self._messages[0].received_ns <= self.time_ns:
            self._inbox.put(self._messages.pop(0))


class Ticks(list[Tick]):
    def put(self, payload: bytes, time_ns: int) -> None:
        self.append(Tick.FromString(payload))


class Nowhere:
    def put(self, payload: bytes, time_ns: int) -> None:
        pass


def test_a_tick_is_stale_exactly_when_its_newest_scan_is_too_old(tmp_path: Path):
    import_log(coreslam_file(), tmp_path / "out.mcap", "coreslam", rate="recorded")
    ticks = ticks_of(read_log(tmp_path / "out.mcap"))
    times_us, _ = slow_coreslam(coreslam_file())
    arrivals_ns = (times_us - times_us[0]) * 1000
    now_ns = PERIOD_NS * np.arange(1, len(ticks) + 1)
    newest_ns = arrivals_ns[np.searchsorted(arrivals_ns, now_ns, side="right") - 1]
    stale = now_ns - newest_ns > round(LIMIT_S * 1e9)
    verdicts = np.array([tick.decision.verdict for tick in ticks])
    np.testing.assert_array_equal(verdicts == Verdict.STALE_INPUT, stale)
    assert 50 < stale.sum() < len(ticks) / 2
    assert set(verdicts) == {Verdict.OK, Verdict.STALE_INPUT, Verdict.RECOVERING}


def ticks_of(log: Log) -> list[Tick]:
    """The ticks of the real node while the scans of a log arrive as their times say."""
    contract = PolicyContract(
        retina=RetinaSpec(rays=16, fov_rad=math.pi, range_m=5.0), max_input_age_s=LIMIT_S
    )
    messages = [
        accepted_message(
            "robot0/scan", r.schema, r.payload, Stamp(r.sequence, r.publish_ns), r.log_ns
        )
        for r in log.records("/robot0/scan")
    ]
    inbox, ticks = Inbox(), Ticks()
    policy = load_policy(exported(contract))
    controller = Controller(policy, contract, ScanSense(contract.retina))
    pacer = RatePacer(1e9 / PERIOD_NS, FileClock(inbox, messages), inbox)
    node = Node(controller, pacer, Outlets(Nowhere(), ticks, Nowhere()))
    node.run(max_ticks=messages[-1].received_ns // PERIOD_NS)
    return ticks[:-1]  # the last one says that it was asked to stop
