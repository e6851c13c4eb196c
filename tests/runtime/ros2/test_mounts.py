"""A scanner sits as the static transforms say: against the product of textbook matrices."""

import math

import numpy as np
import numpy.typing as npt
import pytest
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_runtime.ros2.laser_scan import RosScanner, decode_scan
from reflexarc_runtime.ros2.mounts import MOST_STEPS, PATIENCE_NS, Mounts
from reflexarc_runtime.sensing.mounting import Mount
from reflexarc_runtime.sensing.scan import UnusableScanError
from support.ros2 import laser_scan

Matrix = npt.NDArray[np.float64]


def transform(parent: str, child: str, place: tuple[float, float], roll: float, yaw: float):
    message = FrameTransform(parent_frame_id=parent, child_frame_id=child)
    message.translation.x, message.translation.y = place
    a, b = 0.5 * roll, 0.5 * yaw  # first the roll about x, then the yaw about z
    message.rotation.x = math.sin(a) * math.cos(b)
    message.rotation.y = math.sin(a) * math.sin(b)
    message.rotation.z = math.cos(a) * math.sin(b)
    message.rotation.w = math.cos(a) * math.cos(b)
    return message


def matrix(place: tuple[float, float], roll: float, yaw: float) -> Matrix:
    """Of the same transform, homogeneous, by its textbook form."""
    about_x = np.array(
        [[1, 0, 0], [0, math.cos(roll), -math.sin(roll)], [0, math.sin(roll), math.cos(roll)]]
    )
    about_z = np.array(
        [[math.cos(yaw), -math.sin(yaw), 0], [math.sin(yaw), math.cos(yaw), 0], [0, 0, 1]]
    )
    whole = np.eye(4)
    whole[:3, :3], whole[:2, 3] = about_z @ about_x, place
    return whole


places = st.tuples(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
turns = st.tuples(places, st.sampled_from([0.0, math.pi]), st.floats(-math.pi, math.pi))


@given(st.lists(turns, min_size=1, max_size=4))
def test_a_chain_of_frames_is_the_product_of_its_matrices(chain: list) -> None:
    mounts, whole = Mounts(), np.eye(4)
    names = ["base_link", *(f"frame{i}" for i in range(len(chain) - 1)), "laser"]
    for parent, child, (place, roll, yaw) in zip(names, names[1:], chain, strict=False):
        mounts.learn(transform(parent, child, place, roll, yaw))
        whole = whole @ matrix(place, roll, yaw)
    mount = mounts.of("/laser", 0)
    assert mount is not None
    assert (mount.x_m, mount.y_m) == pytest.approx((whole[0, 3], whole[1, 3]), abs=1e-9)
    assert mount.upside_down == (whole[2, 2] < 0)
    ahead = math.cos(mount.yaw_rad), math.sin(mount.yaw_rad)
    assert ahead == pytest.approx((whole[0, 0], whole[1, 0]), abs=1e-9)


def test_a_loop_of_frames_and_an_unknown_one_lead_nowhere(caplog: pytest.LogCaptureFixture) -> None:
    mounts = Mounts()
    mounts.learn(transform("b", "a", (0, 0), 0, 0))
    mounts.learn(transform("a", "b", (0, 0), 0, 0))
    for frame in ("a", "laser", ""):
        assert mounts.of(frame, 0) is None
    assert not caplog.records
    for _ in range(MOST_STEPS):
        assert mounts.of("laser", PATIENCE_NS) is None
    assert len(caplog.records) == 1
    assert "--mount" in caplog.text


def test_a_tilted_scanner_is_refused() -> None:
    mounts = Mounts()
    mounts.learn(transform("base_link", "laser", (0, 0), 0.5, 0.0))
    with pytest.raises(UnusableScanError, match="tilted"):
        mounts.of("laser", 0)


def test_a_flag_goes_before_what_the_robot_says() -> None:
    payload = laser_scan([1.0, 2.0, 3.0]).serialize()
    said = Mount(0.1, 0.0, math.pi)
    assert decode_scan(payload, mount_in=lambda frame: said).mount == said
    flag = RosScanner(mount=Mount(0.2))
    assert decode_scan(payload, flag, lambda frame: said).mount == Mount(0.2)
