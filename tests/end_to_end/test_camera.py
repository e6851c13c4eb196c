"""A video ↔ `reflexarc camera` ↔ `reflexarc run`."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.RawImage_pb2 import RawImage

from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec, Shading
from reflexarc_runtime.messages_pb2 import Status
from support.images import bar, write_image, write_video
from support.policies import exported
from support.processes import finished, records_of, said_line, started, wait_for_records

COLOURS = PolicyContract(retina=RetinaSpec(rays=4, shading=Shading.COLOUR))


@pytest.fixture
def policy(tmp_path: Path) -> Path:
    """A policy that sees colours with four rays."""
    path = tmp_path / "colours.onnx"
    path.write_bytes(exported(COLOURS, seed=5))
    return path


def bumper_script(port: int) -> str:
    """The bumper of the documentation: free for a while, pressed for a while, gone.

    It counts its calls: a clock would run through both while a busy machine starts it.
    """
    page = (Path(__file__).parents[2] / "docs" / "guard.md").read_text(encoding="utf-8")
    block = page.split("```python\n")[1].split("```")[0]
    assert 'BusConfig(robot="robot0")' in block
    switches = """
import itertools
CALLS = itertools.count()

def switches():
    call = next(CALLS)
    if call >= 120:
        raise SystemExit
    return [call >= 70] * 8
"""
    return switches + block.replace('robot="robot0"', f'robot="robot0", port={port}')


@pytest.mark.long
def test_a_camera_is_guarded_by_the_bumper_of_the_documentation(
    policy: Path, port: int, tmp_path: Path
):
    video, log = tmp_path / "drive.avi", tmp_path / "drive.mcap"
    write_video(video, [bar(16 * (number % 4)) for number in range(3000)], rate_hz=50.0)
    with (
        started("camera", video, "--port", port, "--json") as camera,
        started(
            *("run", policy, "--guard-ranges", "scan", "--port", port, "--record", log, "--json")
        ) as runtime,
    ):
        wait_for_records(log, "tick", 20)
        subprocess.run([sys.executable, "-c", bumper_script(port)], check=True, timeout=60)
        wait_for_records(log, "tick", records_of(log, "tick") + 150)  # three times a status
        finished(runtime, signal.SIGINT)
        finished(camera, signal.SIGINT)
    reasons = [tick.decision.reason for tick in read_log(log).ticks()]
    kinds = ["no ranges yet", "", "is not free, nor is anything else", "no ranges for 0.3 s"]
    first = [next(i for i, r in enumerate(reasons) if r == k or (k and k in r)) for k in kinds]
    assert first == sorted(first)
    said = [status.guard for _, status in read_log(log).messages("/robot0/status", Status)]
    assert any("on: no ranges" in words for words in said)
    report = replay(log)
    assert report.exit_status == 0, report.lines()
    assert report.levels[-1].level == "node"


def test_a_video_drives_a_policy(policy: Path, port: int, tmp_path: Path):
    video, log = tmp_path / "drive.avi", tmp_path / "drive.mcap"
    write_video(video, [bar(16 * (number % 4)) for number in range(40)], rate_hz=50.0)
    words = ("camera", video, "--frames-hz", 2, "--port", port, "--json")
    with started(*words) as camera:
        said_line(camera, "waiting for a runtime")
        with started(
            "run", policy, "--no-guard", "--port", port, "--record", log, "--json"
        ) as runtime:
            account = finished(camera)
            summary = finished(runtime, signal.SIGINT)
    assert account == {"retinas": 40, "undecodable": 0, "frames": 2}
    assert summary["verdicts"]["OK"] > 0
    frames = [f for _, f in read_log(log).messages("/robot0/image", CompressedImage)]
    assert [frame.data[:2] for frame in frames] == [b"\xff\xd8"] * 2  # JPEG
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
    assert account == {"retinas": 11, "undecodable": 1, "frames": 0}
    images = [image for _, image in read_log(log).messages("/robot0/retina", RawImage)]
    brightest = [max(range(4), key=list(image.data).__getitem__) for image in images]
    assert brightest == [0] * 6 + [3] * 5
