"""The present messages of CARMEN's logger, written by hand after its writelog.c."""

import math
from pathlib import Path

import pytest
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame

from reflexarc_logs.importing.lidar_import import ImportReport, import_log
from reflexarc_logs.reading.reader import Log, read_log
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.sensing.mounting import Mount, mount_of
from support.lidar import flaser, odom

SETTINGS = "0 -1.570796 3.141593 1.570796 81.9 0.01 0"
THREE = "3 1.5 2.5 3.5"
TIMES = "100.25 host 100.5"
RAW = f"RAWLASER1 {SETTINGS} {THREE} 0 {TIMES}\n"


def robot_laser(
    ranges: str = f"{THREE} 0",
    laser: str = "1.2 2 0",
    robot: str = "1 2 0",
    times: str = TIMES,
    settings: str = SETTINGS,
    name: str = "ROBOTLASER1",
) -> str:
    return f"{name} {settings} {ranges} {laser} {robot} 0.5 0 0.5 0.3 1e6 {times}\n"


def imported(folder: Path, text: str) -> tuple[ImportReport, Log]:
    source, out = folder / "in.log", folder / "out.mcap"
    source.write_bytes(text.encode())
    said = import_log(source, out, "carmen")
    return said, read_log(out)


def scans(log: Log) -> list[LaserScan]:
    return [scan for _, scan in log.messages("/robot0/scan", LaserScan)]


def places(log: Log, name: str) -> list[tuple[float, float]]:
    found = log.messages(f"/robot0/{name}", PoseInFrame)
    return [(pose.pose.position.x, pose.pose.position.y) for _, pose in found]


def test_a_robot_laser_gives_the_robots_pose_and_how_the_laser_sits_on_it(tmp_path: Path):
    text = odom("7 8 0", "99") + robot_laser()
    said, log = imported(tmp_path, text)
    (scan,) = scans(log)
    assert list(scan.ranges) == [1.5, 2.5, 3.5]
    assert (scan.start_angle, scan.end_angle) == pytest.approx(
        (-math.pi / 2, math.pi / 2), abs=1e-6
    )
    assert scan.timestamp.ToNanoseconds() == 100_250_000_000
    assert mount_of(scan.pose) == Mount(0.2, 0.0, 0.0)
    assert (places(log, "pose"), places(log, "odometry")) == ([(1.0, 2.0)], [(7.0, 8.0)])
    assert (said.poses, said.odometry) == (1, 1)


def test_a_laser_that_looks_backwards_says_so(tmp_path: Path):
    turned = robot_laser(laser="1 1.7 -1.570796", robot="1 2 1.570796")  # 0.3 m behind the middle
    (scan,) = scans(imported(tmp_path, turned)[1])
    mount = mount_of(scan.pose)
    assert (mount.x_m, mount.y_m) == pytest.approx((-0.3, 0.0), abs=1e-4)
    assert abs(mount.yaw_rad) == pytest.approx(math.pi, abs=1e-4)


def test_a_laser_far_from_its_robot_has_a_corrected_pose(tmp_path: Path):
    _, log = imported(tmp_path, robot_laser(laser="41 2 0", robot="1 2 0"))
    assert (places(log, "pose"), places(log, "odometry")) == ([(41.0, 2.0)], [(1.0, 2.0)])
    assert mount_of(scans(log)[0].pose) == Mount()


@pytest.mark.parametrize("remission", ["0", "3 9 8 7", "3 1.0 2.0 3.0", ""])
def test_remission_values_are_passed_over(tmp_path: Path, remission: str):
    _, log = imported(tmp_path, robot_laser(f"{THREE} {remission}"))
    assert list(scans(log)[0].ranges) == [1.5, 2.5, 3.5]
    assert places(log, "pose") == [(1.0, 2.0)]


def test_a_raw_laser_has_no_pose_and_the_odometry_beside_it(tmp_path: Path):
    said, log = imported(tmp_path, (odom("7 8 0", "99") + RAW) * 2)
    assert (said.scans, said.poses, said.odometry) == (2, 0, 2)
    assert list(scans(log)[0].ranges) == [1.5, 2.5, 3.5]


def test_what_reaches_the_scanners_own_largest_range_has_no_return(tmp_path: Path):
    near = robot_laser(settings="0 -1.570796 3.141593 1.570796 3.5 0.01 0")
    assert list(scans(imported(tmp_path, near)[1])[0].ranges) == [1.5, 2.5, math.inf]


def test_one_laser_is_read_where_a_file_has_several(tmp_path: Path):
    rear = flaser().replace("FLASER", "RLASER")
    text = rear + RAW + robot_laser(name="ROBOTLASER2") + robot_laser() + RAW
    said, log = imported(tmp_path, text)
    assert (said.scans, said.poses, said.notes) == (1, 1, ())
    assert said.passed_over == {"RLASER": 1, "RAWLASER1": 2, "ROBOTLASER2": 1}
    assert places(log, "pose") == [(1.0, 2.0)]


def test_a_laser_of_broken_lines_is_not_the_files(tmp_path: Path):
    broken = robot_laser("9 1 2 3 0")
    said, _ = imported(tmp_path, broken * 5 + flaser() * 4 + robot_laser())
    assert said.scans == 4
    assert said.passed_over == {"ROBOTLASER1": 6}


def test_a_rear_laser_alone_is_read_and_named(tmp_path: Path):
    said, log = imported(tmp_path, flaser().replace("FLASER", "RLASER"))
    assert list(scans(log)[0].ranges) == [1.5, 2.5, 3.5]
    assert "RLASER" in said.notes[0]


@pytest.mark.parametrize("text", [flaser(), robot_laser(), RAW])
def test_a_line_without_times_is_a_scan_without_a_time(tmp_path: Path, text: str):
    said, log = imported(tmp_path, " ".join(text.split()[:-3]) + "\n")
    assert list(scans(log)[0].ranges) == [1.5, 2.5, 3.5]
    assert said.times_left_out == 1
    assert scans(log)[0].timestamp.ToNanoseconds() == 0


def test_windows_line_ends_change_nothing(tmp_path: Path):
    copied = flaser(pose="1 2 0.5", odometry="1 2 0.5")
    text = (copied + odom("1 2 0.5", "0") + copied + odom("1 2 0.5", "0.000")) * 3
    plain, log = imported(tmp_path, text)
    (tmp_path / "out.mcap").unlink()
    said, windows = imported(
        tmp_path, "\ufeff# from Windows\n".replace("\n", "\r\n") + text.replace("\n", "\r\n")
    )
    assert (said.scans, said.odometry, said.broken_lines) == (6, 0, {})
    assert plain.odometry == 0
    assert [s.SerializeToString() for s in scans(windows)] == [
        s.SerializeToString() for s in scans(log)
    ]


def test_an_odometry_line_at_the_start_of_a_clock_counts(tmp_path: Path):
    first = "ODOM 7 8 0 0 0 0 100.0 host 0.000000\n"
    _, log = imported(tmp_path, first + flaser(pose="1 2 0.5", odometry="1 2 0.5"))
    assert places(log, "odometry") == [(7.0, 8.0)]


def test_messages_that_the_logger_writes_are_no_broken_lines(tmp_path: Path):
    words = [
        "IMU",
        "NMEAGGA",
        "SONAR",
        "BUMPER",
        "COMMENT",
        "MARKER",
        "ODOMETRY",
        "SCANMARK",
        "POSITIONLASER",
        "ARM",
    ]
    text = "".join(f"{word} 1 2 3\n" for word in words) + "MARKER\n" + flaser()
    said, _ = imported(tmp_path, text)
    assert (said.scans, said.broken_lines) == (1, {})
    assert said.passed_over == {**dict.fromkeys(words, 1), "MARKER": 2}


def test_no_file_can_have_keywords_without_end(tmp_path: Path):
    said, _ = imported(tmp_path, "".join(f"K{k} 1\n" for k in range(5000)) + flaser())
    assert len(said.passed_over) == 101
    assert said.passed_over["other messages"] == 4900


def test_distances_in_centimetres_are_suspected(tmp_path: Path):
    said, _ = imported(tmp_path, flaser("300 310 320") * 2)
    assert "all 6 beams are without return" in said.notes[0]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (flaser(pose="1,5 2 0"), "line 1: a pose or a time is no number, but has a decimal comma"),
        (flaser("1,5 2,5 3,5"), "no beam of its 1 scans has a distance (3 no number)"),
        (flaser("0 -1 nan"), "no beam of its 1 scans has a distance (3 not positive)"),
        (robot_laser("9 1 2 3 0"), "wrong count of ranges"),
        (robot_laser("3 1.5 2.5 3.5 7"), "wrong count of ranges"),
        (robot_laser(settings="0 -90 180 1 81.9 0.01 0"), "angles of no scanner"),
        (robot_laser(settings="0 -1.57 3.14"), "wrong count of ranges"),
        ("ROBOTLASER1\n", "wrong count of ranges"),
        ("RAWLASER1 0 -1.570796 3.141593 1.570796 81.9 0.01 0\n", "wrong count of ranges"),
        (flaser(count=10**9), "wrong count of ranges"),
        (f"FLASER {'9' * 5000} 1 2 3\n", "wrong count of ranges"),
    ],
)  # fmt: skip
def test_a_file_of_which_nothing_is_usable_is_refused(tmp_path: Path, text: str, words: str):
    (tmp_path / "in.log").write_text(text)
    with pytest.raises(LogError) as error:
        import_log(tmp_path / "in.log", tmp_path / "out.mcap", "carmen")
    assert words in str(error.value)
    assert not (tmp_path / "out.mcap").exists()
