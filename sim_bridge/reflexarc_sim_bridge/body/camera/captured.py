"""The images of a device or a video, as OpenCV takes them."""

from collections.abc import Iterator

import cv2
import numpy as np

from reflexarc_sim_bridge.body.camera.eye import Image


def captured(capture: cv2.VideoCapture) -> Iterator[Image | None]:
    """One image after another, red first, until there are no more; None for a broken one."""
    while capture.grab():
        decoded, image = capture.retrieve()
        # OpenCV puts blue first.
        yield np.asarray(image[:, :, ::-1], np.uint8) if decoded else None
