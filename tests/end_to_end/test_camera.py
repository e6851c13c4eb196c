"""A video ↔ `reflexarc camera` ↔ `reflexarc run`."""

import signal
from pathlib import Path

import pytest
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage

from reflexarc_logs.reading.reader import read_log
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec, Shading
from support.images import bar, write_video
from support.policies import exported
from support.processes import finished, said_line, started

COLOURS = PolicyContract(retina=RetinaSpec(rays=4, shading=Shading.COLOUR))


@pytest.fixture
def policy(tmp_path: Path) -> Path:
    """A policy that sees colours with four rays."""
    path = tmp_path / "colours.onnx"
    path.write_bytes(exported(COLOURS, seed=5))
    return path


def test_a_video_drives_a_policy(policy: Path, port: int, tmp_path: Path):
    video, log = tmp_path / "drive.avi", tmp_path / "drive.mcap"
    write_video(video, [bar(16 * (number % 4)) for number in range(40)], rate_hz=50.0)
    with started("camera", video, "--port", port, "--json") as camera:
        said_line(camera, "waiting for a runtime")
        with started(
            "run", policy, "--no-guard", "--port", port, "--record", log, "--json"
        ) as runtime:
            account = finished(camera)
            summary = finished(runtime, signal.SIGINT)
    assert account == {"retinas": 40, "undecodable": 0}
    assert summary["verdicts"]["OK"] > 0
    images = [image for _, image in read_log(log).messages("/robot0/retina", RawImage)]
    assert [max(range(4), key=list(image.data).__getitem__) for image in images] == [
        0,
        1,
        2,
        3,
    ] * 10
