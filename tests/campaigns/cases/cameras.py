"""Pictures as people have them."""

import json
from itertools import groupby
from pathlib import Path

from foxglove_schemas_protobuf.RawImage_pb2 import RawImage

from cases.case import Case, Outcome, Stage, Trial
from reflexarc_logs.reading.reader import read_log
from support.processes import finished, started, wait_until
from support.ros2_robot import free_port

_SIDES = {(1, 2, 3): "left", (12, 13, 14): "right", (): "nothing"}
_SECONDS = 6


def _sides(log: Path) -> list[str]:
    """On which side something is, image by image."""
    found = []
    for _, image in read_log(log).messages("/robot0/retina", RawImage):
        bright = tuple(ray for ray in range(16) if image.data[ray] > 127)
        found.append(_SIDES.get(bright, str(bright)))
    return found


def _shown(stage: Stage, source: str) -> tuple[list[str], dict[str, int]]:
    """The sides that a source shows, and the camera's account."""
    log, port = stage.scratch / "log.mcap", free_port()
    policy = stage.inputs / "colour-policy.onnx"
    record = ("record", "-o", log, "--port", port, "--seconds", _SECONDS, "--json")
    look = ("camera", stage.inputs / source, "--policy", policy, "--port", port, "--rate", 10)
    with started(*record) as recorder:
        wait_until(log.with_name(f"{log.name}.partial").exists, "the recording begins")
        with started(*look, "--json") as camera:
            account = finished(camera)
        finished(recorder)
    return _sides(log), account


def _in_order(stage: Stage) -> Outcome:
    sides, account = _shown(stage, "unpadded")
    runs = [(side, len(list(images))) for side, images in groupby(sides)]
    return Outcome(runs == [("left", 6), ("right", 6)], f"{runs}; {json.dumps(account)}")


def _two_images(stage: Stage) -> Outcome:
    sides, account = _shown(stage, "mac-leftovers")
    return Outcome(len(sides) == 2, f"{sides}; {json.dumps(account)}")


def _refused(source: str, *words: str) -> Trial:
    """Status 2 with these words."""

    def tried(stage: Stage) -> Outcome:
        policy = stage.inputs / "colour-policy.onnx"
        said = stage.reflexarc("camera", stage.inputs / source, "--policy", policy, "--rate", 10)
        holds = said.status == 2 and all(word in said.complaint for word in words)
        return Outcome(holds, f"status {said.status}: {said.complaint.strip()}")

    return tried


CASES = (
    Case("camera", "unpadded/", "six left, then six right", _in_order),
    Case(
        "camera",
        "12-bit-in-16.png",
        "bright, or refused",
        _refused("12-bit-in-16.png", "4080", "--bits 12"),
    ),
    Case(
        "camera",
        "lfs/",
        "status 2: no image could be read, LFS pointers",
        _refused("lfs", "no image could be read", "LFS"),
    ),
    Case(
        "camera",
        "cut/",
        "status 2: no image could be read",
        _refused("cut", "no image could be read"),
    ),
    Case("camera", "mac-leftovers/", "2 images", _two_images),
)
