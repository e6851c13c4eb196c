import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from rosbags.rosbag2 import Reader
from ruamel.yaml import YAML

from reflexarc_logs.bags.bag_export import export_bag
from reflexarc_logs.bags.bag_import import import_bag
from reflexarc_logs.reading.reader import read_log
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages_pb2 import Command
from support.ros2 import Header, LaserScan, Odometry, TFMessage, TwistStamped, laser_scan, transform
from support.ros2 import odometry as said_odometry
from support.ros2_bags import START_NS, Image, pixels, read_mcap, stamp, write_bag

NOMINAL = Path(__file__).parents[2] / "golden" / "nominal.mcap"
RANGES = [0.25, 3.75, math.inf, math.nan, 8.0, -math.inf]
MS = 1_000_000
WHEN = stamp(START_NS - 3 * MS)


@pytest.fixture
def driven(tmp_path: Path) -> Path:
    """A log of a robot's own scans and places, imported from a bag that another library wrote."""
    head = Header(stamp(START_NS - 5 * MS), "laser")
    scan = laser_scan(RANGES, start_rad=-1.0, step_rad=0.25, limits_m=(0.0, 40.0))
    scan.header = head
    fixed = TFMessage([transform("laser", 0.25, parent="base_link")])
    moving = TFMessage([transform("base_link", 1.0, parent="odom")])
    moving.transforms[0].header.stamp = WHEN
    place = said_odometry(3.0, 4.0, stamp=WHEN)
    rows = [
        ("/tf_static", "tf2_msgs/msg/TFMessage", START_NS, fixed.serialize()),
        ("/tf", "tf2_msgs/msg/TFMessage", START_NS + 1, moving.serialize()),
        ("/scan", "sensor_msgs/msg/LaserScan", START_NS + 2, scan.serialize()),
        ("/odom", "nav_msgs/msg/Odometry", START_NS + 3, place.serialize()),
    ]
    import_bag(write_bag(tmp_path / "original", rows), tmp_path / "driven.mcap")
    return tmp_path / "driven.mcap"


def test_a_bag_has_the_profile_and_the_qualities_that_ros_tools_ask_for(
    tmp_path: Path, driven: Path
):
    export_bag(read_log(driven), tmp_path / "bag")
    profile, rows, qualities = read_mcap(tmp_path / "bag" / "bag.mcap")
    assert profile == "ros2"
    assert [(topic, kind) for topic, kind, _, _ in rows] == [
        ("/tf_static", "tf2_msgs/msg/TFMessage"),
        ("/tf", "tf2_msgs/msg/TFMessage"),
        ("/tf_static", "tf2_msgs/msg/TFMessage"),  # where the scanner sits
        ("/scan", "sensor_msgs/msg/LaserScan"),
        ("/odom", "nav_msgs/msg/Odometry"),
    ]
    for topic, words in qualities.items():
        [quality] = YAML(typ="safe").load(words)
        # rmw's numbers: 1 reliable; 1 transient local, 2 volatile; 1 keep last
        expected = 1 if topic == "/tf_static" else 2
        assert (quality["reliability"], quality["durability"], quality["history"]) == (
            1,
            expected,
            1,
        )


def test_the_metadata_of_the_folder_are_those_of_rosbag2(tmp_path: Path, driven: Path):
    export_bag(read_log(driven), tmp_path / "bag")
    about = YAML(typ="safe").load(tmp_path / "bag" / "metadata.yaml")
    said = about["rosbag2_bagfile_information"]
    assert (said["version"], said["storage_identifier"]) == (8, "mcap")
    assert said["relative_file_paths"] == ["bag.mcap"], "the name under which it was begun"
    assert said["starting_time"]["nanoseconds_since_epoch"] == START_NS
    assert said["message_count"] == 5
    assert not list(tmp_path.glob("*.exporting"))


def test_a_scan_is_read_by_another_library_as_it_was(tmp_path: Path, driven: Path):
    export_bag(read_log(driven), tmp_path / "bag")
    [found] = [
        LaserScan.deserialize(data)
        for topic, _, _, data in read_mcap(tmp_path / "bag" / "bag.mcap")[1]
        if topic == "/scan"
    ]
    assert np.array_equal(found.ranges, RANGES, equal_nan=True)
    assert (found.angle_min, found.angle_max, found.angle_increment) == (-1.0, 0.25, 0.25)
    assert found.range_max == 9.0, "a range at the limit would mean that nothing was met"
    assert found.header == Header(stamp(START_NS - 5 * MS), "scan_frame")


def test_an_odometry_says_which_frame_is_there(tmp_path: Path, driven: Path):
    export_bag(read_log(driven), tmp_path / "bag")
    [found] = [
        Odometry.deserialize(data)
        for topic, _, _, data in read_mcap(tmp_path / "bag" / "bag.mcap")[1]
        if topic == "/odom"
    ]
    assert (found.header.frame_id, found.child_frame_id) == ("odom", "base_link")
    assert (found.pose.pose.position.x, found.pose.pose.position.y) == (3.0, 4.0)


def test_out_and_in_again_says_the_same_bytes(tmp_path: Path, driven: Path):
    export_bag(read_log(driven), tmp_path / "bag")
    import_bag(tmp_path / "bag", tmp_path / "again.mcap")
    for topic in ("/robot0/scan", "/robot0/odometry", "/robot0/tf"):
        was, now = (
            [(r.log_ns, r.payload) for r in read_log(log).records(topic)]
            for log in (driven, tmp_path / "again.mcap")
        )
        assert was == now
        assert was


def test_where_a_scanner_sits_is_said_once_and_comes_in_again(tmp_path: Path, driven: Path):
    """A scan of ROS names a frame and has no pose: without the frame the scanner would move."""
    export_bag(read_log(driven), tmp_path / "bag")
    said = [
        TFMessage.deserialize(data).transforms[0]
        for topic, _, _, data in read_mcap(tmp_path / "bag" / "bag.mcap")[1]
        if topic == "/tf_static"
    ]
    assert [(t.header.frame_id, t.child_frame_id) for t in said] == [
        ("base_link", "laser"),
        ("base_link", "scan_frame"),
    ]
    assert said[1].transform == said[0].transform


def test_retinas_and_commands_of_a_run_come_out_on_the_wall_clock(tmp_path: Path):
    log = read_log(NOMINAL)
    report = export_bag(log, tmp_path / "bag")
    assert report.messages == {"/cmd_vel": 301, "/retina": 300}
    assert report.left_out == {"/robot0/keyframe": 6, "/robot0/stop": 1, "/robot0/tick": 301}
    rows = read_mcap(tmp_path / "bag" / "bag.mcap")[1]
    seen = [Image.deserialize(data) for topic, _, _, data in rows if topic == "/retina"]
    retinas = list(log.messages("/robot0/retina", RawImage))
    offset_ns = log.run.wall_offset_ns
    for found, (record, retina) in zip(seen, retinas, strict=True):
        sent_ns = retina.timestamp.ToNanoseconds()
        assert sent_ns == record.publish_ns, "the payload stays on the sender's clock"
        assert found.header == Header(stamp(sent_ns + offset_ns), "robot0")
        assert (found.encoding, found.width, found.height) == ("mono8", 16, 1)
        assert pixels(found).tobytes() == retina.data
    twists = [TwistStamped.deserialize(data) for topic, _, _, data in rows if topic == "/cmd_vel"]
    commands = [command for _, command in log.messages("/robot0/command", Command)]
    assert [t.twist.linear.x for t in twists] == [c.linear_mps for c in commands]
    assert [t.twist.linear.y for t in twists] == [c.lateral_mps for c in commands]


def test_the_times_of_a_bag_are_the_arrivals(tmp_path: Path):
    log = read_log(NOMINAL)
    export_bag(log, tmp_path / "bag")
    with Reader(tmp_path / "bag") as bag:
        times: list[Any] = [time_ns for _, time_ns, _ in bag.messages()]
    kept = ("/robot0/retina", "/robot0/command")
    assert times == sorted(record.log_ns for record in log.records(*kept))


def test_what_is_there_is_never_overwritten(tmp_path: Path):
    (tmp_path / "bag").mkdir()
    with pytest.raises(LogError, match="exists already"):
        export_bag(read_log(NOMINAL), tmp_path / "bag")


def test_the_same_log_makes_the_same_bag(tmp_path: Path, driven: Path):
    names = "a", "b"
    for name in names:
        export_bag(read_log(driven), tmp_path / name / "bag")
    one, other = ((tmp_path / name / "bag" / "bag.mcap").read_bytes() for name in names)
    assert one == other
