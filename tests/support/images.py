"""Images and videos for a camera's tests."""

from pathlib import Path

import cv2
import numpy as np

from reflexarc_sim_bridge.body.camera.eye import Image

RED = (220, 10, 10)
BLUE = (10, 10, 220)


def bar(
    first: int, *, width: int = 16, columns: int = 64, colour: tuple[int, int, int] = RED
) -> Image:
    """A bar of colour on black, 32 rows high."""
    image = np.zeros((32, columns, 3), np.uint8)
    image[:, first : first + width] = colour
    return image


def write_image(path: Path, image: Image) -> None:
    assert cv2.imwrite(str(path), image[:, :, ::-1])


def write_video(path: Path, images: list[Image], rate_hz: float) -> None:
    """Motion JPEG, as simple cameras write it."""
    height, width = images[0].shape[:2]
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), rate_hz, (width, height))
    for image in images:
        writer.write(np.ascontiguousarray(image[:, :, ::-1]))
    writer.release()
