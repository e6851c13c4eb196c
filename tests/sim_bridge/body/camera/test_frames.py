"""Images on the bus: at a rate, in their colours, side by side, small enough."""

import cv2
import numpy as np
import pytest
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage

from reflexarc_runtime.messages.wire import MAX_PAYLOAD_BYTES
from reflexarc_sim_bridge.body.camera.frames import FramePace, encode_frame

MS = 1_000_000


def shown_of(data: bytes) -> np.ndarray:
    """Decoded by the library, red first."""
    picture = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    assert picture is not None
    return picture[:, :, ::-1]


@pytest.mark.parametrize(
    ("camera_hz", "rate_hz", "expected"), [(30, 5, 50), (30, 15, 150), (10, 30, 100), (25, 10, 100)]
)
def test_ten_seconds_of_a_camera_give_at_most_the_frames_asked_for(camera_hz, rate_hz, expected):
    pace, rng = FramePace(rate_hz), np.random.default_rng(1)
    jitter_ns = rng.integers(-MS, MS, 10 * camera_hz)
    times_ns = [round(1e9 * i / camera_hz) + int(late) for i, late in enumerate(jitter_ns)]
    shown = [t for t in times_ns if pace.is_due(t)]
    assert abs(len(shown) - expected) <= 1
    assert len(shown) <= 10 * rate_hz + 1


def test_a_pause_is_not_made_up_for():
    pace = FramePace(10.0)
    assert pace.is_due(0)
    times_ns = range(5_000 * MS, 5_185 * MS, 10 * MS)
    assert sum(pace.is_due(t) for t in times_ns) == 2


def test_colours_and_eyes_are_where_they_were():
    left, right = np.zeros((16, 24, 3), np.uint8), np.zeros((32, 8, 3), np.uint8)
    left[:, :, 0], right[:, :, 2] = 200, 100
    message = CompressedImage.FromString(encode_frame((left, right), "rover", 1_500 * MS))
    assert (message.format, message.frame_id) == ("jpeg", "rover/camera")
    assert (message.timestamp.seconds, message.timestamp.nanos) == (1, 500 * MS)
    shown = shown_of(message.data).astype(int)
    assert shown.shape == (32, 32, 3)
    for (row, column), colour in {
        (8, 8): (200, 0, 0),
        (8, 28): (0, 0, 100),
        (30, 8): (0, 0, 0),
    }.items():
        assert np.abs(shown[row, column] - colour).max() < 12


def test_a_picture_too_large_for_the_bus_is_halved():
    noise = np.random.default_rng(2).integers(0, 256, (1500, 2000, 3), np.uint8)
    payload = encode_frame((noise,), "robot0", 0)
    assert len(payload) <= MAX_PAYLOAD_BYTES
    rows, columns, _ = shown_of(CompressedImage.FromString(payload).data).shape
    assert (rows, columns) in [(750, 1000), (375, 500)]
