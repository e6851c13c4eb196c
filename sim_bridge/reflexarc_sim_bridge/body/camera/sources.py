"""Sources of images: a device, a video file, or image files. Only this module imports cv2."""

import glob
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import cv2
import numpy as np

from reflexarc_runtime.errors import UsageError, WorldError
from reflexarc_sim_bridge.body.camera.eye import Image

IMAGE_SUFFIXES = frozenset(
    (".png", ".jpg", ".jpeg", ".bmp", ".ppm", ".pgm", ".tif", ".tiff", ".webp")
)

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
        """One image after another; None for one that cannot be decoded."""
        ...


@dataclass(frozen=True)
class Device:
    """A camera of this machine. Iterating over its frames waits for each of them."""

    number: int
    wanted_hz: float | None = None
    """The rate that is asked for; the device may have another."""
    rate_hz = None
    total = None

    def frames(self) -> Iterator[Image | None]:
        """See `ImageSource.frames`.

        Raises:
            WorldError: the camera gives no more images.
        """
        capture = cv2.VideoCapture(self.number)
        capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)  # the newest image, not one from a queue
        if self.wanted_hz is not None:
            capture.set(cv2.CAP_PROP_FPS, self.wanted_hz)
        try:
            yield from _captured(capture)
        finally:
            capture.release()
        raise WorldError(f"camera {self.number}: gives no more images; is it still plugged in?")


@dataclass(frozen=True)
class Video:
    """A video file."""

    path: Path
    rate_hz: float | None
    total: int
    """As the file says; some estimate it."""

    def frames(self) -> Iterator[Image | None]:
        """See `ImageSource.frames`."""
        capture = cv2.VideoCapture(str(self.path))
        try:
            yield from _captured(capture)
        finally:
            capture.release()


@dataclass(frozen=True)
class Images:
    """Image files, in the order of their names."""

    paths: tuple[Path, ...]
    rate_hz = None

    @property
    def total(self) -> int:
        """See `ImageSource.total`."""
        return len(self.paths)

    def frames(self) -> Iterator[Image | None]:
        """See `ImageSource.frames`."""
        for path in self.paths:
            image = cv2.imread(str(path), cv2.IMREAD_COLOR)
            yield None if image is None else _red_first(image)


def source_named(name: str, wanted_hz: float | None = None) -> ImageSource:
    """A device by its number, a video file, an image, a folder of images, or a glob of them.

    Raises:
        UsageError: none of these.
        WorldError: the device cannot be opened.
    """
    # OpenCV prints a line for every file and device that it cannot open; the errors here say it.
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    if name.isdecimal():
        return _device(int(name), wanted_hz)
    path = Path(name)
    if path.is_dir():
        return _images(name, path.iterdir())
    if path.is_file():
        return _images(name, [path]) if _is_image(path) else _video(path)
    if any(sign in name for sign in _GLOB_SIGNS):
        return _images(name, map(Path, glob.glob(name)))
    raise UsageError(f"{name}: expected a camera's number, a video, a folder or a glob of images")


def _device(number: int, wanted_hz: float | None) -> Device:
    """A device that opens. It is closed again, as one that is not read keeps old images."""
    capture = cv2.VideoCapture(number)
    opens = capture.isOpened()
    capture.release()
    if not opens:
        raise WorldError(f"camera {number}: cannot be opened; is it there, and free?")
    return Device(number, wanted_hz)


def _images(name: str, paths: Iterable[Path]) -> Images:
    images = tuple(sorted(path for path in paths if _is_image(path)))
    if not images:
        known = " ".join(sorted(IMAGE_SUFFIXES))
        raise UsageError(f"{name}: expected images ({known}), found none")
    return Images(images)


def _is_image(path: Path) -> bool:
    return path.suffix.lower() in IMAGE_SUFFIXES


def _video(path: Path) -> Video:
    capture = cv2.VideoCapture(str(path))
    try:
        if not capture.isOpened():
            raise UsageError(f"{path}: expected a video or an image, got neither")
        rate_hz, total = capture.get(cv2.CAP_PROP_FPS), capture.get(cv2.CAP_PROP_FRAME_COUNT)
        return Video(path, rate_hz if rate_hz > 0.0 else None, max(int(total), 0))
    finally:
        capture.release()


def _captured(capture: cv2.VideoCapture) -> Iterator[Image | None]:
    while capture.grab():
        decoded, image = capture.retrieve()
        yield _red_first(image) if decoded else None


def _red_first(image: cv2.typing.MatLike) -> Image:
    """Reverse the order of the channels: OpenCV puts blue first."""
    return np.asarray(image[:, :, ::-1], np.uint8)
