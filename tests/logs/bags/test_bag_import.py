import math
import re
from pathlib import Path

import numpy as np
import pytest
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage as FoxgloveCompressed
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from rosbags.rosbag2 import StoragePlugin

from reflexarc_logs.bags.bag_import import import_bag
from reflexarc_logs.bags.bag_streams import BagWishes
from reflexarc_logs.reading.reader import Log, read_log
from reflexarc_runtime.errors import LogError, UsageError
from support.ros2 import Header, TFMessage, laser_scan, odometry, transform
from support.ros2 import LaserScan as RosScan
from support.ros2_bags import START_NS, CompressedImage, Row, image, stamp, write_bag

MS = 1_000_000
SCAN, ODOM, TF = "sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry", "tf2_msgs/msg/TFMessage"
IMAGE, COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"


def scan(number: int, frame: str = "laser") -> RosScan:
    ranges = [1.0 + number, 2.5, math.inf, math.nan]
    found = laser_scan(ranges, start_rad=-0.75, step_rad=0.5, limits_m=(0.0, 40.0))
    found.header = Header(stamp(START_NS + number * 100 * MS - 7 * MS), frame)
    return found


def rows(scans: int = 3) -> list[Row]:
    """A robot that scans, drives, and looks through two cameras."""
    found: list[Row] = [("/tf_static", TF, START_NS, tf("base_link", "laser"))]
    for k in range(scans):
        at_ns = START_NS + k * 100 * MS
        found += [
            ("/scan", SCAN, at_ns, scan(k).serialize()),
            ("/odom", ODOM, at_ns + 1, odometry(k, 2.0).serialize()),
            ("/tf", TF, at_ns + 2, tf("odom", "base_link")),
            ("/camera/image_raw", IMAGE, at_ns + 3, image("rgb8", width=6).serialize()),
            ("/camera/compressed", COMPRESSED, at_ns + 4, jpeg("rgb8; jpeg compressed bgr8")),
            ("/chatter", "std_msgs/msg/String", at_ns + 5, b"\0\1\0\0\2\0\0\0x\0"),
        ]
    return found


def tf(parent: str, child: str, x_m: float = 0.0) -> bytes:
    return TFMessage([transform(child, x_m, parent=parent)]).serialize()


def jpeg(words: str) -> bytes:
    return CompressedImage(Header(), words, [1, 2, 3]).serialize()


def imported(folder: Path, bag: Path, wishes: BagWishes | None = None) -> Log:
    import_bag(bag, folder / "out.mcap", wishes)
    return read_log(folder / "out.mcap")


@pytest.mark.parametrize("plugin", list(StoragePlugin))
@pytest.mark.parametrize("as_file", [False, True])
def test_a_bag_comes_in_whatever_it_is_stored_as(
    tmp_path: Path, plugin: StoragePlugin, as_file: bool
):
    bag = write_bag(tmp_path / "bag", rows(), plugin)
    [file] = [f for f in bag.iterdir() if f.suffix in (".mcap", ".db3")]
    report = import_bag(file if as_file else bag, tmp_path / "out.mcap")
    assert report.messages == {
        "/robot0/camera/compressed": 3,
        "/robot0/camera/image_raw": 3,
        "/robot0/odometry": 3,
        "/robot0/scan": 3,
        "/robot0/tf": 3,
        "/robot0/tf_static": 1,
    }
    assert (report.left_out, report.unusable) == ({"/chatter": 3}, {})
    assert report.seconds == pytest.approx(0.2, abs=1e-6)


def test_what_a_scan_says_comes_through(tmp_path: Path):
    log = imported(tmp_path, write_bag(tmp_path / "bag", rows()))
    record, message = list(log.messages("/robot0/scan", LaserScan))[2]
    assert (record.log_ns, record.publish_ns) == (START_NS + 200 * MS,) * 2
    assert message.timestamp.ToNanoseconds() == START_NS + 193 * MS
    assert (message.start_angle, message.end_angle) == (-0.75, 0.75)
    assert np.array_equal(message.ranges, [3.0, 2.5, math.inf, math.nan], equal_nan=True)


def test_places_and_pictures_come_through(tmp_path: Path):
    log = imported(tmp_path, write_bag(tmp_path / "bag", rows()))
    _, pose = list(log.messages("/robot0/odometry", PoseInFrame))[2]
    assert (pose.frame_id, pose.pose.position.x, pose.pose.position.y) == ("odom", 2.0, 2.0)
    _, turn = next(log.messages("/robot0/tf", FrameTransform))
    assert (turn.parent_frame_id, turn.child_frame_id) == ("odom", "base_link")
    _, fixed = next(log.messages("/robot0/tf_static", FrameTransform))
    assert (fixed.parent_frame_id, fixed.child_frame_id) == ("base_link", "laser")
    _, raw = next(log.messages("/robot0/camera/image_raw", RawImage))
    assert (raw.encoding, raw.width, raw.height, raw.data) == ("rgb8", 6, 3, bytes(range(18)))
    _, packed = next(log.messages("/robot0/camera/compressed", FoxgloveCompressed))
    assert (packed.format, packed.data) == ("jpeg", b"\1\2\3")


def test_a_scanner_sits_as_the_fixed_frames_say_wherever_they_stand_in_the_bag(tmp_path: Path):
    late = [row for row in rows() if row[0] != "/tf_static"]
    fixed = tf("base_link", "laser", 0.25)
    late.append(("/tf_static", TF, START_NS + 900 * MS, fixed))
    log = imported(tmp_path, write_bag(tmp_path / "bag", late))
    _, message = next(log.messages("/robot0/scan", LaserScan))
    assert (message.pose.position.x, message.pose.position.y) == (0.25, 0.0)
    assert message.frame_id == "base_link", "a viewer would add the scanner's place once more"


def test_the_scan_is_chosen_by_name_where_there_are_several(tmp_path: Path):
    several = [(t.replace("/scan", "/front"), k, at, p) for t, k, at, p in rows()]
    several += [("/back", SCAN, START_NS, scan(9).serialize())]
    bag = write_bag(tmp_path / "bag", several)
    with pytest.raises(UsageError, match=r"several topics of .*: /front, /back"):
        import_bag(bag, tmp_path / "out.mcap")
    with pytest.raises(UsageError, match=r"expected a topic of .*the bag has /front, /back"):
        import_bag(bag, tmp_path / "out.mcap", BagWishes(scan="left"))
    assert not list(tmp_path.glob("out*")), "nothing is left"
    report = import_bag(bag, tmp_path / "out.mcap", BagWishes("rover", scan="front"))
    assert (report.messages["/rover/scan"], report.messages["/rover/back"]) == (3, 1)


def test_a_picture_is_never_taken_for_a_retina(tmp_path: Path):
    log = imported(
        tmp_path, write_bag(tmp_path / "bag", [("/retina", IMAGE, 5, image().serialize())])
    )
    assert [record.topic for record in log.records()] == ["/robot0/ros/retina"]


UNUSABLE: dict[str, tuple[str, bytes, str]] = {
    "big-endian pixels": (IMAGE, image("mono16", big=1).serialize(), "pixels with their high byte"),
    "too few pixels": (IMAGE, image().serialize()[:-4], "no sensor_msgs/msg/Image"),
    "a depth image": (COMPRESSED, jpeg("16UC1; compressedDepth png"), "no viewer knows"),
    "noise": (SCAN, b"\0\1\0\0\xff\xff", "no sensor_msgs/msg/LaserScan"),
    "the other byte order": (SCAN, b"\0\0" + scan(0).serialize()[2:], "no little-endian CDR"),
}


@pytest.mark.parametrize("name", list(UNUSABLE))
def test_what_cannot_be_used_is_counted_by_its_reason(tmp_path: Path, name: str):
    kind, payload, reason = UNUSABLE[name]
    bag = write_bag(tmp_path / "bag", [*rows(), ("/odd", kind, START_NS, payload)])
    report = import_bag(bag, tmp_path / "out.mcap")
    [(said, count)] = report.unusable.items()
    assert said.startswith("/odd: ")
    assert reason in said
    assert count == 1


NO_BAG: dict[str, str] = {
    "missing": "found nothing there",
    "folder": "no metadata.yaml",
    "file.bag": "rosbags-convert",
    "file.txt": "expected a bag: a folder",
    "noise.mcap": "cannot read it",
    "noise.db3": "cannot read it",
}


@pytest.mark.parametrize("name", list(NO_BAG))
def test_what_is_no_bag_is_refused_in_words(tmp_path: Path, name: str):
    place = tmp_path / name
    if name == "folder":
        place.mkdir()
    elif name != "missing":
        place.write_bytes(b"no bag at all, whatever it is called" * 9)
    with pytest.raises(LogError, match=re.escape(NO_BAG[name])):
        import_bag(place, tmp_path / "out.mcap")
    assert not list(tmp_path.glob("out*"))


def test_a_bag_of_other_things_is_refused_with_what_it_has(tmp_path: Path):
    bag = write_bag(tmp_path / "bag", [row for row in rows() if row[0] == "/chatter"])
    with pytest.raises(LogError, match=r"expected scans.*found std_msgs/msg/String"):
        import_bag(bag, tmp_path / "out.mcap")
    assert not list(tmp_path.glob("out*"))


@pytest.mark.parametrize("cut", [0.3, 0.6, 0.95])
def test_a_bag_that_was_cut_off_is_refused_or_read_and_never_a_traceback(
    tmp_path: Path, cut: float
):
    [file] = write_bag(tmp_path / "bag", rows(50)).glob("*.mcap")
    whole = file.read_bytes()
    part = tmp_path / "part.mcap"
    part.write_bytes(whole[: int(len(whole) * cut)])
    with pytest.raises(LogError, match="recover"):
        import_bag(part, tmp_path / "out.mcap")
