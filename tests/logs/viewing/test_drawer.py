import math
from pathlib import Path

import numpy as np
import pytest
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.Log_pb2 import Log as FoxgloveLog
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from hypothesis import example, given
from hypothesis import strategies as st

from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.viewing import drawings as things
from reflexarc_logs.viewing.drawer import Drawer
from reflexarc_logs.viewing.log_view import action_names, view_log
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.decision import Verdict
from reflexarc_runtime.messages.codec import encode_contact, encode_retina
from reflexarc_runtime.messages.topics import TOPICS

GOLDEN = Path(__file__).parents[2] / "golden"


class Sketch:
    """A canvas that remembers."""

    def __init__(self) -> None:
        self.drawn: list[tuple[int, int | None, things.Drawing]] = []
        self.fixed: list[things.Drawing] = []
        self._now: tuple[int, int | None] = (0, None)

    def at(self, time_ns: int, tick: int | None) -> None:
        self._now = time_ns, tick

    def draw(self, drawing: things.Drawing) -> None:
        self.drawn.append((*self._now, drawing))

    def fix(self, drawing: things.Drawing) -> None:
        self.fixed.append(drawing)


def scan(**fields: object) -> LaserScan:
    return LaserScan(**fields)  # type: ignore[arg-type]  # the fields of the message


def posed(x_m: float, y_m: float, heading_rad: float) -> bytes:
    message = PoseInFrame(frame_id="world")
    message.pose.position.x, message.pose.position.y = x_m, y_m
    message.pose.orientation.z = math.sin(heading_rad / 2)
    message.pose.orientation.w = math.cos(heading_rad / 2)
    return message.SerializeToString()


def test_the_points_of_a_scan_are_where_its_beams_end():
    message = scan(start_angle=-math.pi / 2, end_angle=math.pi / 2)
    message.ranges.extend([1.0, 2.0, math.inf, math.nan, 4.0])
    message.pose.position.x, message.pose.orientation.w = 0.5, 1.0
    [points] = Drawer().drawings("scan", "foxglove.LaserScan", message.SerializeToString())
    assert isinstance(points, things.DrawnPoints)
    half = math.sqrt(0.5)
    expected = [[0.5, -1.0, 0.0], [0.5 + 2 * half, -2 * half, 0.0], [0.5, 4.0, 0.0]]
    assert np.allclose(points.points_m, expected)


def test_a_retina_is_a_strip_that_is_wide_enough_to_see():
    payload = encode_retina(np.arange(16, dtype=np.uint8).reshape(1, 16, 1), RetinaSpec(rays=16), 0)
    [picture] = Drawer().drawings("retina", "foxglove.RawImage", payload)
    assert isinstance(picture, things.DrawnPicture)
    assert np.array_equal(picture.pixels, [np.arange(16)] * 2)


def test_a_camera_s_picture_keeps_its_colours():
    raw = RawImage(width=2, height=1, encoding="bgr8", step=8, data=bytes([1, 2, 3, 4, 5, 6, 0, 0]))
    [picture] = Drawer().drawings("camera/raw", "foxglove.RawImage", raw.SerializeToString())
    assert isinstance(picture, things.DrawnPicture)
    assert picture.place == "images/camera/raw"
    assert picture.pixels.tolist() == [[[3, 2, 1], [6, 5, 4]]]


def test_a_packed_picture_goes_out_as_it_is():
    packed = CompressedImage(data=b"jpeg", format="jpeg").SerializeToString()
    assert Drawer().drawings("front", "foxglove.CompressedImage", packed) == [
        things.DrawnFile("images/front", b"jpeg", "image/jpeg")
    ]


def test_the_way_is_where_the_robot_was():
    drawer = Drawer()
    for k in range(40):
        [stand, *_] = drawer.drawings("pose", "foxglove.PoseInFrame", posed(0.1 * k, 2.0, 0.25))
    assert isinstance(stand, things.DrawnFrame)
    assert (stand.x_m, stand.y_m) == (pytest.approx(3.9), 2.0)
    assert stand.heading_rad == pytest.approx(0.25)
    assert np.allclose(drawer.way().points_m, [[0.1 * k, 2.0, 0.0] for k in range(40)])


def test_odometry_counts_only_where_nobody_says_a_pose():
    drawer = Drawer()
    assert drawer.drawings("odometry", "foxglove.PoseInFrame", posed(1.0, 1.0, 0.0))
    assert drawer.drawings("pose", "foxglove.PoseInFrame", posed(2.0, 1.0, 0.0))
    assert drawer.drawings("odometry", "foxglove.PoseInFrame", posed(3.0, 1.0, 0.0)) == []


def test_a_scene_is_boxes_discs_and_triangles_until_it_is_replaced():
    update = SceneUpdate()
    entity = update.entities.add(id="obstacles")
    cube = entity.cubes.add()
    cube.pose.position.x, cube.size.x, cube.size.y, cube.size.z = 1.0, 2.0, 3.0, 0.5
    cube.color.r, cube.color.a = 1.0, 1.0
    disc = entity.cylinders.add()
    disc.pose.position.y, disc.size.x, disc.size.z = 4.0, 1.0, 0.5
    fan = entity.triangles.add()
    for x, y in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)):
        fan.points.add(x=x, y=y)
    fan.indices.extend([0, 2, 1])
    drawer = Drawer()
    boxes, discs, triangles = drawer.drawings(
        "scene", "foxglove.SceneUpdate", update.SerializeToString()
    )
    assert isinstance(boxes, things.DrawnBoxes)
    assert boxes.sizes_m.tolist() == [[2.0, 3.0, 0.5]]
    assert boxes.colours.tolist() == [[255, 0, 0, 255]]
    assert isinstance(discs, things.DrawnDiscs)
    assert (discs.centres_m.tolist(), discs.radii_m.tolist()) == ([[0.0, 4.0, 0.0]], [0.5])
    assert isinstance(triangles, things.DrawnTriangles)
    assert triangles.corners_m.tolist() == [[0, 0, 0], [0, 1, 0], [1, 0, 0]]
    update.entities[0].ClearField("cubes")
    [boxes, *_] = drawer.drawings("scene", "foxglove.SceneUpdate", update.SerializeToString())
    assert isinstance(boxes, things.DrawnBoxes)
    assert len(boxes.centres_m) == 0


def test_a_verdict_is_said_when_it_changes_and_q_values_at_every_tick():
    tick = pb.Tick()
    tick.decision.verdict = int(Verdict.GUARDED)  # type: ignore[assignment]  # the stub's own enum
    tick.decision.reason = "stay is not free"
    tick.decision.q_values.extend([1.0, 2.5])
    tick.decision.command.linear_mps = 0.5
    drawer, payload = Drawer(), tick.SerializeToString()
    assert drawer.drawings("tick", "reflexarc.Tick", payload) == [
        things.DrawnNumbers("q_values", (1.0, 2.5)),
        things.DrawnNumbers("command", (0.5, 0.0, 0.0)),
        things.DrawnWords("events/verdict", "tick 0: GUARDED: stay is not free", "WARN"),
    ]
    assert len(drawer.drawings("tick", "reflexarc.Tick", payload)) == 2


def test_contacts_and_logs_are_said():
    contact = Drawer().drawings("contact", "reflexarc.Contact", encode_contact(3, 1.0, -2.0, 0))
    assert contact == [things.DrawnWords("events/contact", "contact 3 at 1.00, -2.00 m", "ERROR")]
    log = FoxgloveLog(level=FoxgloveLog.WARNING, message="late").SerializeToString()
    assert Drawer().drawings("log", "foxglove.Log", log) == [
        things.DrawnWords("events/log", "late", "WARN")
    ]


@given(st.sampled_from(TOPICS), st.binary(max_size=60))
def test_noise_draws_nothing_or_something_and_never_fails(topic, noise):
    Drawer().drawings(topic.name, topic.schema, noise)


floats = st.floats(allow_nan=True, allow_infinity=True)


@given(floats, floats, st.lists(floats, max_size=6), floats, floats)
@example(math.inf, 1.0, [1.0, 2.0], 0.0, 1.0)
@example(0.0, 1e308, [1.0, 2.0], 0.0, 1.0)
@example(-1e308, 1e308, [1e308, 2.0], 0.0, 1.0)
@example(0.0, 1.0, [1.0, 2.0], 1e308, 1.0)
def test_no_numbers_of_a_scan_or_a_pose_do_harm(start, end, ranges, x, w):
    message = scan(start_angle=start, end_angle=end)
    message.ranges.extend(ranges)
    message.pose.position.x, message.pose.orientation.w = x, w
    Drawer().drawings("scan", "foxglove.LaserScan", message.SerializeToString())
    pose = PoseInFrame()
    pose.pose.position.x, pose.pose.orientation.w = x, w
    Drawer().drawings("pose", "foxglove.PoseInFrame", pose.SerializeToString())


def test_a_whole_log_is_drawn_on_its_wall_clock():
    log, sketch = read_log(GOLDEN / "nominal.mcap"), Sketch()
    assert view_log(log, sketch) == 300 + 301  # retinas and ticks
    by_place: dict[str, list[int]] = {}
    for time_ns, _, drawing in sketch.drawn:
        by_place.setdefault(drawing.place, []).append(time_ns)
    assert by_place["retina"] == [r.log_ns for r in log.records("/robot0/retina")]
    assert by_place["command"] == [r.log_ns for r in log.records("/robot0/tick")]
    assert [tick for _, tick, d in sketch.drawn if d.place == "command"] == list(range(301))
    assert action_names(log.policy) == ("stay", "left", "right")


def test_rerun_writes_what_it_is_given(tmp_path: Path):
    pytest.importorskip("rerun")
    from reflexarc_logs.viewing.rerun_canvas import RerunCanvas

    log = read_log(GOLDEN / "nominal.mcap")
    canvas = RerunCanvas("nominal", log.run.run_id, action_names(log.policy))
    canvas.to_file(tmp_path / "out.rrd")
    view_log(log, canvas)
    canvas.finish()
    assert (tmp_path / "out.rrd").read_bytes().startswith(b"RR")
