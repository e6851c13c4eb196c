"""Sources of images: a device, a video file, or image files."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Protocol

import cv2

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.body.camera.device import device_named
from reflexarc_sim_bridge.body.camera.eye import Image
from reflexarc_sim_bridge.body.camera.formats.inspect import is_image
from reflexarc_sim_bridge.body.camera.image_files import (
    has_image_suffix,
    images_in,
    images_of_folder,
    images_of_glob,
)
from reflexarc_sim_bridge.body.camera.names import shown
from reflexarc_sim_bridge.body.camera.video import video_in

_GLOB_SIGNS = "*?["


class ImageSource(Protocol):
    """A stream of images."""

    @property
    def rate_hz(self) -> float | None:
        """Images a second, where the source knows it."""
        ...

    @property
    def total(self) -> int | None:
        """How many images there are; None where they never end."""
        ...

    def frames(self) -> Iterator[Image | None]:
        """One image after another; None for one that cannot be read."""
        ...


def source_named(
    name: str,
    wanted_hz: float | None = None,
    bits: int | None = None,
    say: Callable[[str], None] = lambda line: None,
) -> ImageSource:
    """A device by its number or path, a video file, an image, a folder of images, or a glob.

    Args:
        name: of the source.
        wanted_hz: the rate that a device is asked for.
        bits: how many of 16 bits the camera of deep pictures gives; None: they must show it.
        say: is told, a line each, which images are left out.

    Raises:
        UsageError: none of these, or one that gives no image.
        WorldError: the device cannot be opened.
    """
    # OpenCV prints a line for every file and device that it cannot open; the errors here say it.
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    stream = _stream_named(name, wanted_hz, say)
    if stream is None:
        return _images_named(name, bits, say)
    if bits is not None:
        raise UsageError(f"--bits: expected image files, got {shown(name)}")
    return stream


def _stream_named(
    name: str, wanted_hz: float | None, say: Callable[[str], None]
) -> ImageSource | None:
    device = device_named(name, wanted_hz)
    if device is not None:
        return device
    path = Path(name)
    if path.is_file() and not has_image_suffix(path) and not _holds_image(path):
        return video_in(path, say)
    return None


def _images_named(name: str, bits: int | None, say: Callable[[str], None]) -> ImageSource:
    path = Path(name)
    if path.is_dir():
        return images_of_folder(path, bits, say)
    if path.is_file():
        return images_in(name, [path], bits, say)
    if any(sign in name for sign in _GLOB_SIGNS):
        return images_of_glob(name, bits, say)
    raise UsageError(
        f"{shown(name)}: expected a camera's number, a video, a folder or a glob of images"
    )


def _holds_image(path: Path) -> bool:
    """Whether a file of any name holds an image: FFmpeg would choose a depth for it."""
    try:
        with path.open("rb") as file:
            return is_image(file.read(64))
    except OSError:
        return False  # told where it is opened as a video
