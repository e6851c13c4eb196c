"""A video file as a source."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.body.camera.captured import captured
from reflexarc_sim_bridge.body.camera.eye import Image
from reflexarc_sim_bridge.body.camera.formats.facts import UnreadableImageError
from reflexarc_sim_bridge.body.camera.formats.inspect import refuse_stand_in
from reflexarc_sim_bridge.body.camera.names import shown

_OTHER_PICTURES = frozenset(
    (
        *(".avif", ".exr", ".gif", ".hdr", ".heic", ".heif", ".j2k", ".jp2", ".jxl", ".pfm"),
        *(".cr2", ".cr3", ".dng", ".nef", ".raw", ".dpx", ".pcx", ".psd", ".svg", ".tga", ".xpm"),
    )
)
"""Kinds of picture that FFmpeg opens as a video of one image, with a depth of its own choice, or
with white where it is transparent."""


@dataclass(frozen=True)
class Video:
    """A video file."""

    path: Path
    rate_hz: float | None
    total: int
    """As the file says; some estimate it."""
    say: Callable[[str], None]

    def frames(self) -> Iterator[Image | None]:
        """See `ImageSource.frames`."""
        capture, count = _opened(self.path), 0
        try:
            for image in captured(capture):
                count += 1
                yield image
        finally:
            capture.release()
        if count < self.total:
            self.say(f"{shown(self.path)}: ended after {count} of {self.total} images")


def video_in(path: Path, say: Callable[[str], None]) -> Video:
    """A video file that gives at least one image.

    Raises:
        UsageError: it is none, or gives none.
    """
    _check(path)
    capture = _opened(path)
    try:
        if not capture.isOpened():
            raise UsageError(f"{shown(path)}: expected a video or an image, got neither")
        rate_hz, total = capture.get(cv2.CAP_PROP_FPS), capture.get(cv2.CAP_PROP_FRAME_COUNT)
        if not any(image is not None for image in captured(capture)):
            raise UsageError(f"{shown(path)}: no image could be read: the video gives none")
        return Video(path, rate_hz if rate_hz > 0.0 else None, max(int(total), 0), say)
    finally:
        capture.release()


def _check(path: Path) -> None:
    if path.suffix.lower() in _OTHER_PICTURES:
        raise UsageError(
            f"{shown(path)}: expected a video or an image, got a kind of image that is not read; "
            "save it as PNG"
        )
    try:
        with path.open("rb") as file:
            refuse_stand_in(file.read(64))
    except OSError as error:
        raise UsageError(f"{shown(path)}: cannot be read: {error.strerror}") from None
    except UnreadableImageError as error:
        raise UsageError(f"{shown(path)} {error}") from None


def _opened(path: Path) -> cv2.VideoCapture:
    """The video, turned upright where it says how it was held."""
    capture = cv2.VideoCapture(str(path))
    capture.set(cv2.CAP_PROP_ORIENTATION_AUTO, 1.0)
    return capture
