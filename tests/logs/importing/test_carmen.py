import gzip
import math
from decimal import Decimal
from pathlib import Path

import pytest
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame

from reflexarc_logs.importing.lidar_import import ImportReport, import_log
from reflexarc_logs.importing.text_blocks import MAX_LINE_BYTES
from reflexarc_logs.reading.reader import Log, read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.errors import LogError, UsageError
from support.lidar import CARMEN, carmen_file, flaser, odom, slow_carmen

S = 1_000_000_000


def imported(folder: Path, text: str | bytes, **wishes: object) -> tuple[ImportReport, Log]:
    source, out = folder / "in.log", folder / "out.mcap"
    source.write_bytes(text if isinstance(text, bytes) else text.encode())
    said = import_log(source, out, "carmen", **wishes)  # type: ignore[arg-type]  # as given
    return said, read_log(out)


def packed(text: bytes) -> bytes:
    """Gzip without the time of day, so that tests have the same names in every worker."""
    return gzip.compress(text, mtime=0)


def refused(folder: Path, text: str | bytes, **wishes: object) -> str:
    with pytest.raises(LogError) as error:
        imported(folder, text, **wishes)
    assert [path.name for path in folder.iterdir()] == ["in.log"]
    assert "\n" not in str(error.value)
    return str(error.value)


def scans(log: Log) -> list[LaserScan]:
    return [scan for _, scan in log.messages("/robot0/scan", LaserScan)]


def poses(log: Log, name: str) -> list[PoseInFrame]:
    return [pose for _, pose in log.messages(f"/robot0/{name}", PoseInFrame)]


def heading_of(pose: PoseInFrame) -> float:
    turn = pose.pose.orientation
    return 2 * math.atan2(turn.z, turn.w)


def test_a_scan_its_pose_its_transform_and_its_odometry_are_written(tmp_path: Path):
    said, log = imported(tmp_path, flaser("1.5 2.5 3.5"))
    (scan,), (pose,), (odometry,) = scans(log), poses(log, "pose"), poses(log, "odometry")
    assert list(scan.ranges) == [1.5, 2.5, 3.5]
    assert (scan.start_angle, scan.end_angle) == (-math.pi / 2, math.pi / 2)
    assert scan.frame_id == "robot0"
    assert (pose.frame_id, pose.pose.position.x, pose.pose.position.y) == ("world", 1.0, 2.0)
    assert heading_of(pose) == pytest.approx(0.5)
    assert (odometry.frame_id, odometry.pose.position.x) == ("odom", 4.0)
    assert heading_of(odometry) == pytest.approx(0.25)
    ((_, transform),) = log.messages("/robot0/tf", FrameTransform)
    assert (transform.parent_frame_id, transform.child_frame_id) == ("world", "robot0")
    assert transform.translation.y == 2.0
    assert transform.rotation.z == pose.pose.orientation.z
    assert (said.scans, said.poses, said.odometry, said.beams) == (1, 1, 1, 3)


def test_no_return_is_infinite_and_what_is_no_distance_is_unknown(tmp_path: Path):
    words = "49.99 50 51.06 81.83 inf 0 -1 nan x 1_0"
    said, log = imported(tmp_path, flaser(words))
    ranges = list(scans(log)[0].ranges)
    assert ranges[:5] == [49.99, math.inf, math.inf, math.inf, math.inf]
    assert all(map(math.isnan, ranges[5:]))
    assert said.no_return == 4
    assert said.unknown == {"not positive": 3, "no number": 2}


def test_every_kind_of_broken_line_is_counted_and_left_out(tmp_path: Path):
    lines = [
        flaser(),
        flaser(count=4),
        flaser("1 2", count=3),
        flaser(pose="1 2 x"),
        flaser(time="late"),
        flaser(time="0e99999999999999999999"),
        flaser(pose="1 nan 0"),
        "FLASER\n",
        "FLASER 1 2.5 1 2 0.5 1 2 0.5 1 host 1\n",
        "FLASERS 3\n",
        "\xff\xfe\n",
        "\n",
        "# a comment\n",
        "PARAM a b\n",
        flaser("1 " * MAX_LINE_BYTES),
        flaser(),
        flaser()[:-30],
    ]
    said, log = imported(tmp_path, "".join(lines))
    assert len(scans(log)) == said.scans == 2
    assert said.broken_lines == {
        "wrong count of ranges": 4,
        "a pose or a time is no number": 4,
        "unknown keyword": 1,
        "longer than 1 MiB": 1,
        "cut off at the end of the file": 1,
    }
    assert said.first_broken_line == 2
    assert said.passed_over == {"FLASERS": 1, "#": 1, "PARAM": 1}
    assert said.lines == len(lines)


def test_the_beams_of_a_broken_line_are_not_counted(tmp_path: Path):
    said, _ = imported(tmp_path, flaser("1 x x", pose="1 2 x") + flaser("1 2 x"))
    assert (said.beams, said.unknown) == (3, {"no number": 1})


def test_a_whole_last_line_needs_no_end(tmp_path: Path):
    said, _ = imported(tmp_path, flaser() + flaser().rstrip())
    assert (said.scans, said.broken_lines) == (2, {})


def test_odometry_that_repeats_the_pose_is_taken_from_the_line_before(tmp_path: Path):
    copied = flaser(pose="1 2 0.5", odometry="1 2 0.5")
    text = (
        odom("7 0 0", "99")
        + odom("8 0 0", "100.25")
        + copied
        + odom("1 2 0.5", "0")  # what the mapper adds
        + copied  # nothing new
        + odom("9 0 0", "101")
        + flaser(odometry="4 5 0.25")
        + "ODOM 1 2 broken\n"
        + copied
    )
    said, log = imported(tmp_path, text)
    found = poses(log, "odometry")
    assert [pose.pose.position.x for pose in found] == [8.0, 4.0]
    assert found[0].timestamp.ToNanoseconds() == 100_250_000_000
    assert (said.scans, said.odometry) == (4, 2)
    assert said.passed_over == {"ODOM": 5, "ODOM, broken": 1}


@pytest.mark.parametrize("time", ["1e300", "-1e300", "253402300800"])
def test_a_time_of_no_calendar_is_left_out_and_counted(tmp_path: Path, time: str):
    said, log = imported(tmp_path, flaser(time=time))
    assert said.times_left_out == 1
    assert scans(log)[0].timestamp.ToNanoseconds() == 0


def test_a_negative_time_stays_in_the_message(tmp_path: Path):
    _, log = imported(tmp_path, flaser(time="-0.445999"))
    stamp = scans(log)[0].timestamp
    assert (stamp.seconds, stamp.nanos) == (-1, 554_001_000)


def test_scans_are_spread_evenly_from_zero(tmp_path: Path):
    _, log = imported(tmp_path, flaser(time="5") * 7, rate=3.0)
    records = list(log.records("/robot0/scan"))
    assert [r.log_ns for r in records] == [round(k * S / 3) for k in range(7)]
    assert [r.publish_ns for r in records] == [r.log_ns for r in records]
    assert [r.sequence for r in records] == list(range(7))


def test_recorded_times_begin_at_zero_and_keep_their_intervals(tmp_path: Path):
    text = "".join(flaser(time=time) for time in ("-1.5", "0.25", "600.25"))
    said, log = imported(tmp_path, text, rate="recorded")
    assert [r.log_ns for r in log.records("/robot0/scan")] == [0, 1_750_000_000, 601_750_000_000]
    assert (said.seconds, said.rate_hz) == (601.75, 0.0)


@pytest.mark.parametrize(
    ("times", "words"),
    [
        ("5 6 4 7 3", "line 3: a step back (in 5 scans: 2 × a step back)"),
        ("5 5 6", "line 2: a repeated time"),
        ("5 606", "line 2: a jump of more than 600 s"),
        ("5 1e300", "line 2: no time of any calendar"),
        ("5 5 4 1000", "line 2: a repeated time (in 4 scans: 1 × a rep"),
    ],
)
def test_recorded_times_that_do_not_grow_are_refused(tmp_path: Path, times: str, words: str):
    said = refused(tmp_path, "".join(flaser(time=t) for t in times.split()), rate="recorded")
    assert words in said
    assert "--rate 10" in said


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (b"", "empty"),
        (b"\n\n", "no scan in 2 lines"),
        (b"\x89MCAP0\r\n\0\0\0", "binary"),
        (packed(b"\0" * 100), "binary"),
        (packed(b""), "empty"),
        (packed(flaser().encode() * 99)[:-9], "damaged gzip"),
        (packed(flaser().encode()) + b"rubbish", "damaged gzip"),
        (b"\x1f\x8b nothing", "damaged gzip"),
        (b"1 2 3 4\n", "expected a carmen log"),
        (b"PARAM a b\n" + odom("1 2 3", "4").encode(), "no scan in 2 lines"),
    ],
)
def test_what_is_no_carmen_log_is_refused_and_leaves_nothing(
    tmp_path: Path, text: bytes, words: str
):
    assert words in refused(tmp_path, text)


def test_gzip_is_known_by_its_content(tmp_path: Path):
    said, _ = imported(tmp_path, packed(flaser().encode() * 3))
    assert said.scans == 3


def test_a_missing_file_and_a_folder_are_refused(tmp_path: Path):
    for path in (tmp_path / "none", tmp_path):
        with pytest.raises(LogError, match="cannot be read"):
            import_log(path, tmp_path / "out.mcap", "carmen")
    assert not list(tmp_path.iterdir())


def test_a_log_that_exists_is_never_overwritten(tmp_path: Path):
    (tmp_path / "out.mcap").write_text("mine")
    with pytest.raises(LogError, match="exists"):
        imported(tmp_path, flaser())
    assert (tmp_path / "out.mcap").read_text() == "mine"


def test_wrong_wishes_are_refused_before_anything_is_written(tmp_path: Path):
    for rate in (0.0, -1.0, math.nan, 1001.0, "fast"):
        with pytest.raises(UsageError, match="--rate"):
            imported(tmp_path, flaser(), rate=rate)
    with pytest.raises(UsageError, match="carmen or coreslam"):
        import_log(tmp_path / "in.log", tmp_path / "out.mcap", "kitti")
    assert not (tmp_path / "out.mcap").exists()


def test_the_log_says_that_it_was_imported_and_does_not_replay(tmp_path: Path):
    _, log = imported(tmp_path, flaser(), robot="rover1")
    assert (log.run.recorded_by, log.run.input, log.run.wall_offset_ns) == ("import", "scan", 0)
    assert log.run.robot == "rover1"
    assert {r.topic for r in log.records()} >= {"/rover1/scan", "/rover1/odometry"}
    assert b'"carmen"' in (log.config or b"")
    with pytest.raises(LogError, match="no policy"):
        replay(log)


@pytest.mark.parametrize("name", CARMEN)
def test_real_logs_are_imported_to_the_letter(tmp_path: Path, name: str):
    said = import_log(carmen_file(name), tmp_path / "out.mcap", "carmen")
    log = read_log(tmp_path / "out.mcap")
    expected = slow_carmen(carmen_file(name))
    assert len(expected) == said.scans == said.poses
    largest = max(max(ranges) for ranges, _, _ in expected)
    for scan, pose, (ranges, place, time) in zip(
        scans(log), poses(log, "pose"), expected, strict=True
    ):
        assert list(scan.ranges) == [math.inf if r >= 50 else r for r in ranges]
        assert [pose.pose.position.x, pose.pose.position.y] == place[:2]
        assert math.remainder(heading_of(pose) - place[2], math.tau) == pytest.approx(0, abs=1e-9)
        assert scan.timestamp.ToNanoseconds() == int(Decimal(time) * 10**9)
    assert largest >= 50
    assert (said.broken_lines, said.unknown) == ({}, {})


@pytest.mark.parametrize(
    ("name", "fault"),
    [
        ("aces", ""),
        ("seattle", ""),
        ("csail", "404 × a repeated time"),
        ("intel", "4 × a step back"),
        ("infinite-corridor", "3 × a step back"),
    ],
)
def test_real_logs_keep_their_times_only_where_they_grow(tmp_path: Path, name: str, fault: str):
    out = tmp_path / "out.mcap"
    if fault:
        with pytest.raises(LogError, match=fault):
            import_log(carmen_file(name), out, "carmen", rate="recorded")
        assert not list(tmp_path.iterdir())
        return
    import_log(carmen_file(name), out, "carmen", rate="recorded")
    times = [Decimal(time) for _, _, time in slow_carmen(carmen_file(name))]
    got = [record.log_ns for record in read_log(out).records("/robot0/scan")]
    assert got == [int((time - times[0]) * 10**9) for time in times]
