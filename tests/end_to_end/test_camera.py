"""A video ↔ `reflexarc camera` ↔ `reflexarc run`."""

import signal
from pathlib import Path

import pytest
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage

from reflexarc_logs.reading.reader import read_log
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec, Shading
from support.images import bar, write_image, write_video
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


def test_a_folder_is_shown_in_the_order_of_its_numbers_and_what_is_broken_is_counted(
    policy: Path, port: int, tmp_path: Path
):
    folder, log = tmp_path / "frames", tmp_path / "drive.mcap"
    folder.mkdir()
    for number in range(1, 13):
        write_image(folder / f"frame{number}.png", bar(0 if number <= 6 else 48))
    cut = folder / "frame9.png"
    cut.write_bytes(cut.read_bytes()[:-20])
    (folder / "._frame1.png").write_bytes(b"left over")
    with started("camera", folder, "--rate", 50, "--port", port, "--json") as camera:
        said_line(camera, "waiting for a runtime")
        with started(
            "run", policy, "--no-guard", "--port", port, "--record", log, "--json"
        ) as runtime:
            assert "frame9.png is cut" in said_line(camera, "frame9")
            account = finished(camera)
            finished(runtime, signal.SIGINT)
    assert account == {"retinas": 11, "undecodable": 1}
    images = [image for _, image in read_log(log).messages("/robot0/retina", RawImage)]
    brightest = [max(range(4), key=list(image.data).__getitem__) for image in images]
    assert brightest == [0] * 6 + [3] * 5
