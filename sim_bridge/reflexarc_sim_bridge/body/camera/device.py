"""A camera of this machine: by its number, or by its path as Linux names it."""

import os
import re
import stat
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2

from reflexarc_runtime.errors import WorldError
from reflexarc_sim_bridge.body.camera.captured import captured
from reflexarc_sim_bridge.body.camera.eye import Image
from reflexarc_sim_bridge.body.camera.names import shown

_NODE = re.compile(r"/dev/video([0-9]+)")
_VIDEO_MAJOR = 81
"""Linux's number for the drivers of cameras (its admin-guide/devices.txt)."""


@dataclass(frozen=True)
class Device:
    """A camera of this machine. Iterating over its frames waits for each of them."""

    address: int | str
    """Its number, or the path of its node."""
    wanted_hz: float | None = None
    """The rate that is asked for; the device may have another."""
    rate_hz = None
    total = None

    def frames(self) -> Iterator[Image | None]:
        """See `ImageSource.frames`.

        Raises:
            WorldError: the camera gives no more images.
        """
        capture = cv2.VideoCapture(self.address)
        capture.set(cv2.CAP_PROP_BUFFERSIZE, 1)  # the newest image, not one from a queue
        if self.wanted_hz is not None:
            capture.set(cv2.CAP_PROP_FPS, self.wanted_hz)
        count = 0
        try:
            for image in captured(capture):
                count += 1
                yield image
        finally:
            capture.release()
        gives = "gives no more images; is it still plugged in?" if count else "gave no image"
        raise WorldError(f"camera {shown(self.address)}: {gives}")


def device_named(name: str, wanted_hz: float | None) -> Device | None:
    """The camera of a name; None where the name is none of a device.

    Raises:
        WorldError: there is no such camera, it may not be opened, or it cannot be.
    """
    path = Path(name)
    if name.isascii() and name.isdecimal():
        device = Device(int(name), wanted_hz)
        node = Path(f"/dev/video{int(name)}")
        _check(device, node, _hint_of_a_file(name), sys.platform == "linux")
        return device
    if _is_node(path) or (name.startswith("/dev/") and not path.exists()):
        node = path.resolve()
        number = _NODE.fullmatch(str(node))
        device = Device(int(number[1]) if number else str(node), wanted_hz)
        _check(device, path, "", has_nodes=True)
        return device
    return None


def _check(device: Device, node: Path, hint: str, has_nodes: bool) -> None:
    """Say why a camera does not open. It is closed again: one that is not read keeps old images."""
    where = f"camera {shown(device.address)}"
    if has_nodes:
        _check_node(where, node, hint)
    capture = cv2.VideoCapture(device.address)
    opens = capture.isOpened()
    capture.release()
    if not opens:
        raise WorldError(
            f"{where}: cannot be opened; does another program hold it, or is it one of its "
            f"camera's nodes that give no images?{hint}"
        )


def _check_node(where: str, node: Path, hint: str) -> None:
    if not node.exists():
        raise WorldError(f"{where}: cannot be opened: there is no {shown(node)}{hint}")
    status = node.stat()
    if not stat.S_ISCHR(status.st_mode) or os.major(status.st_rdev) != _VIDEO_MAJOR:
        raise WorldError(f"{where}: cannot be opened: {shown(node)} is no camera")
    if not os.access(node, os.R_OK | os.W_OK):
        raise WorldError(
            f"{where}: cannot be opened: no right to {shown(node)}; "
            "join the group that has it, mostly video: sudo usermod -aG video $USER"
        )


def _hint_of_a_file(name: str) -> str:
    """A folder may be named 2024; a number is always a camera."""
    return f"; the file or folder of this name is ./{name}" if Path(name).exists() else ""


def _is_node(path: Path) -> bool:
    return path.is_char_device() or path.is_block_device()
