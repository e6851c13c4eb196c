"""The importer against a slow one: each line alone, protobuf messages, the library's writer."""

import gzip
import io
import math
from collections.abc import Iterator
from decimal import Decimal
from pathlib import Path

import pytest
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from mcap.reader import make_reader
from mcap.writer import Writer
from mcap_protobuf.schema import register_schema

from reflexarc_logs.importing import lidar_reading
from reflexarc_logs.importing import text_blocks as text_file
from reflexarc_logs.importing.lidar_import import import_log
from reflexarc_runtime.errors import LogError
from support.lidar import CARMEN, carmen_file, coreslam, coreslam_file, flaser, odom

RATE_HZ = 10
Place = tuple[float, float, float, Decimal]
Slow = tuple[str, LaserScan | PoseInFrame | FrameTransform]


def slow_scan(ranges: list[float], right_deg: float, left_deg: float, time_s: Decimal) -> Slow:
    scan = LaserScan(frame_id="robot0", ranges=ranges)
    scan.start_angle, scan.end_angle = math.radians(right_deg), math.radians(left_deg)
    scan.pose.orientation.w = 1.0
    scan.timestamp.seconds, scan.timestamp.nanos = divmod(int(time_s * 10**9), 10**9)
    return "scan", scan


def slow_pose(name: str, frame: str, place: Place) -> Slow:
    pose = PoseInFrame(frame_id=frame)
    x, y, heading, time_s = place
    pose.pose.position.x, pose.pose.position.y = x, y
    pose.pose.orientation.z, pose.pose.orientation.w = math.sin(heading / 2), math.cos(heading / 2)
    pose.timestamp.seconds, pose.timestamp.nanos = divmod(int(time_s * 10**9), 10**9)
    return name, pose


def slow_transform(place: Place) -> Slow:
    _, pose = slow_pose("", "", place)
    assert isinstance(pose, PoseInFrame)
    transform = FrameTransform(parent_frame_id="world", child_frame_id="robot0")
    transform.timestamp.CopyFrom(pose.timestamp)
    transform.translation.x, transform.translation.y = place[:2]
    transform.rotation.z, transform.rotation.w = pose.pose.orientation.z, pose.pose.orientation.w
    return "tf", transform


def slow_place(words: list[bytes], time: bytes) -> Place:
    x, y, heading = map(float, words)
    return x, y, heading, Decimal(time.decode())


def slow_carmen_messages(lines: list[bytes]) -> Iterator[list[Slow]]:
    newest = None
    for line in lines:
        words = line.split()
        if words[:1] == [b"ODOM"] and words[7] != b"0":
            newest = slow_place(words[1:4], words[7])
        if words[:1] != [b"FLASER"] or words[1:2] != [b"%d" % (len(words) - 11)]:
            continue
        *numbers, time, _, _ = words[2:]
        try:
            pose, wheels = slow_place(numbers[-6:-3], time), slow_place(numbers[-3:], time)
        except ValueError:
            continue
        metres = [float(word) for word in numbers[:-6]]
        known = [math.inf if r >= 50 else r if r > 0 else math.nan for r in metres]
        left_deg = 89.0 if len(known) == 180 else 90.0  # SICK scanners leave out their last beam
        messages = [slow_scan(known, -90.0, left_deg, pose[3])]
        messages += [slow_pose("pose", "world", pose), slow_transform(pose)]
        odometry = newest if numbers[-6:-3] == numbers[-3:] else wheels
        newest = None
        yield [*messages, slow_pose("odometry", "odom", odometry)] if odometry else messages


def slow_coreslam_messages(lines: list[bytes]) -> Iterator[list[Slow]]:
    for line in lines:
        words = line.split()
        if len(words) in (706, 707) and line.endswith(b"\n"):
            numbers = [int(word) for word in words[24:706]]
            metres = [math.inf if n == 0 else n / 1000 if n >= 20 else math.nan for n in numbers]
            metres[:70] = metres[-70:] = [math.nan] * 70
            time_s = Decimal(words[0].decode()).scaleb(-6)
            yield [slow_scan(metres, -120.0, 120.0, time_s)]


def slow_import(text: bytes, kind: str) -> bytes:
    """The log that should come of a text."""
    read = slow_carmen_messages if kind == "carmen" else slow_coreslam_messages
    file, channels = io.BytesIO(), {}
    writer = Writer(file)
    writer.start()
    for number, messages in enumerate(read(io.BytesIO(text).readlines())):
        for name, message in messages:
            if name not in channels:
                schema = register_schema(writer, type(message))
                channels[name] = writer.register_channel(f"/robot0/{name}", "protobuf", schema)
            time_ns = round(number * 10**9 / RATE_HZ)
            data = message.SerializeToString()
            writer.add_message(channels[name], time_ns, data, time_ns, number)
    writer.finish()  # type: ignore[no-untyped-call]  # mcap has no type for it
    return file.getvalue()


def messages_of(log: bytes) -> dict[str, list[tuple[object, ...]]]:
    """All that its reader gives, by topic; the sequence of `odometry` counts its own messages."""
    found: dict[str, list[tuple[object, ...]]] = {}
    for schema, channel, m in make_reader(io.BytesIO(log), validate_crcs=True).iter_messages():
        assert schema is not None
        at = found.setdefault(channel.topic, [])
        sequence = len(at) if channel.topic.endswith("odometry") else m.sequence
        form = (schema.name, schema.encoding, schema.data, channel.message_encoding)
        at.append((*form, sequence, m.log_time, m.publish_time, m.data))
    return found


def check_the_same(folder: Path, text: bytes, kind: str) -> None:
    source, out = folder / "in.log", folder / "out.mcap"
    source.write_bytes(text)
    import_log(source, out, kind, rate=float(RATE_HZ))
    log = out.read_bytes()
    out.unlink()
    expected = messages_of(slow_import(text, kind))
    assert messages_of(log) == expected
    summary = make_reader(io.BytesIO(log)).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    assert summary.statistics.message_count == sum(map(len, expected.values()))


@pytest.mark.parametrize("name", CARMEN)
def test_real_carmen_logs_are_imported_message_for_message(tmp_path: Path, name: str):
    check_the_same(tmp_path, gzip.decompress(carmen_file(name).read_bytes()), "carmen")


def test_the_real_coreslam_log_is_imported_message_for_message(tmp_path: Path):
    check_the_same(tmp_path, gzip.decompress(coreslam_file().read_bytes()), "coreslam")


BLOCK_BYTES = (1, 7, 50, 100, 333, 5000)


@pytest.mark.parametrize("block_bytes", BLOCK_BYTES)
def test_no_line_is_lost_or_changed_at_the_border_of_two_blocks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, block_bytes: int
):
    monkeypatch.setattr(text_file, "_BLOCK_BYTES", block_bytes)
    repeated = flaser("1.5  2.25\t81.83 0", pose="1 0 -0.5", odometry="1 0 -0.5", count=4)
    lines = [
        odom("7 0.5 0.25", "99.5"),
        repeated,
        flaser(count=9),
        odom("8 0.5 0.25", "100.5"),
        flaser("1 2", pose="x 2 3"),
        "\n",
        odom("1 0 -0.5", "0"),
        repeated,
        flaser("3.125 -1 12345678.5 1e1 .5 5."),
        repeated,
    ]
    check_the_same(tmp_path, "".join(lines * 3).encode(), "carmen")


@pytest.mark.parametrize("block_bytes", BLOCK_BYTES)
def test_coreslam_lines_are_whole_whatever_the_blocks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, block_bytes: int
):
    monkeypatch.setattr(text_file, "_BLOCK_BYTES", block_bytes)
    lines = [coreslam([k, 20, 0, 5600, *[300 + k] * 678]) for k in range(3)]
    lines.insert(1, coreslam([300] * 680))
    check_the_same(tmp_path, "".join(lines).encode(), "coreslam")


def test_a_full_disk_is_an_error_and_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    source = tmp_path / "in.log"
    source.write_text(flaser())
    monkeypatch.setattr("reflexarc_logs.container.writing.LogWriter.add", full)
    with pytest.raises(LogError, match="cannot be written: No space left on device"):
        import_log(source, tmp_path / "out.mcap", "carmen")
    assert [path.name for path in tmp_path.iterdir()] == ["in.log"]


@pytest.mark.parametrize("filler", ["\n", "IMU 1\n", "rubbish\n"])
def test_a_file_without_scans_is_given_up_before_its_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, filler: str
):
    monkeypatch.setattr(lidar_reading, "MOST_LINES", 50_000)
    source = tmp_path / "in.log"
    source.write_text(flaser() + filler * 200_000)
    with pytest.raises(LogError, match=r"found no scan in \d+ lines from line"):
        import_log(source, tmp_path / "out.mcap", "carmen")
    assert [path.name for path in tmp_path.iterdir()] == ["in.log"]
