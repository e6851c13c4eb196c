"""The images themselves on the bus, for whoever records or looks: JPEG, at a rate of their own.

Nothing decides on them; the retina does. Two eyes are shown side by side, the left one first.
"""

import cv2
import numpy as np
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage

from reflexarc_runtime.messages.codec import timestamp
from reflexarc_runtime.messages.wire import MAX_PAYLOAD_BYTES
from reflexarc_sim_bridge.body.camera.eye import Image

QUALITY = 85
_ROOM_BYTES = 1024
"""For what stands around the picture in its message."""


class FramePace:
    """Says which images are shown, at most so many a second.

    The grid of times is fixed: an image that comes a little late does not delay the next one, so
    every second image of a camera of 30 Hz is shown at 15 Hz.
    """

    def __init__(self, rate_hz: float) -> None:
        self._period_ns = round(1e9 / rate_hz)
        self._due_ns: int | None = None

    def is_due(self, now_ns: int) -> bool:
        """Whether the image of this time is shown."""
        early_ns = self._period_ns // 10  # a camera's own times jitter
        if self._due_ns is not None and now_ns < self._due_ns - early_ns:
            return False
        since_ns = now_ns if self._due_ns is None else self._due_ns
        if now_ns - since_ns > self._period_ns:
            since_ns = now_ns  # after a pause the grid begins anew
        self._due_ns = since_ns + self._period_ns
        return True


def encode_frame(images: tuple[Image, ...], robot: str, time_ns: int) -> bytes:
    """The images of one moment as `foxglove.CompressedImage`, halved until they fit on the bus.

    Args:
        images: one for each eye, red, green, blue: (rows, columns, 3).
        robot: whose camera it is.
        time_ns: source time.
    """
    picture = _side_by_side(images)
    data = _jpeg(picture)
    while len(data) > MAX_PAYLOAD_BYTES - _ROOM_BYTES:
        half = cv2.resize(picture, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
        picture = half.astype(np.uint8, copy=False)
        data = _jpeg(picture)
    return CompressedImage(
        timestamp=timestamp(time_ns), frame_id=f"{robot}/camera", data=data, format="jpeg"
    ).SerializeToString()


def _side_by_side(images: tuple[Image, ...]) -> Image:
    rows = max(image.shape[0] for image in images)
    padded = [np.pad(image, ((0, rows - image.shape[0]), (0, 0), (0, 0))) for image in images]
    return np.hstack(padded)


def _jpeg(picture: Image) -> bytes:
    blue_first = np.ascontiguousarray(picture[:, :, ::-1])
    _, data = cv2.imencode(".jpg", blue_first, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    return data.tobytes()
