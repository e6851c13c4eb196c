import os
import socket
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from reflexarc.main import main
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec, Shading
from reflexarc_runtime.contract.motion import sideways_actions
from support.images import bar, write_image
from support.policies import exported


@pytest.fixture
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    colours = PolicyContract(retina=RetinaSpec(rays=4, fov_rad=1.5, shading=Shading.COLOUR))
    (tmp_path / "colours.onnx").write_bytes(exported(colours))
    racer = replace(colours, actions=sideways_actions(30.0))
    (tmp_path / "racer.onnx").write_bytes(exported(racer))
    (tmp_path / "nearness.onnx").write_bytes(exported(PolicyContract()))
    (tmp_path / "text.avi").write_text("none")
    (tmp_path / "ears.toml").write_text("[ears]")
    (tmp_path / "narrow.toml").write_text("[lens]\nfov_rad = 1.0")
    write_image(tmp_path / "frame.png", bar(0))
    _write_hard_images(tmp_path)
    return tmp_path


def _write_hard_images(folder: Path) -> None:
    for name in ("lfs", "pair", "dark", "more"):
        (folder / name).mkdir()
    (folder / "lfs" / "1.png").write_text("version https://git-lfs.github.com/spec/v1\n")
    for name in ("pair/left_1.png", "pair/right_1.png", "more/1.png", "more/2.png"):
        write_image(folder / name, bar(0))
    (folder / os.fsdecode(b"\xff\n.png")).write_bytes(b"")
    assert cv2.imwrite(str(folder / "dark" / "1.png"), np.full((2, 2), 4080, np.uint16))


SEES = ["--policy", "colours.onnx"]


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ([], "STR"),
        (["none.avi"], "none.avi"),
        (["text.avi"], "text.avi"),
        (["97"], "camera 97"),
        (["/dev/null"], "/dev/null is no camera"),
        (["*.jpg"], "found none"),
        (["lfs"], "no image could be read: 1.png is a Git LFS pointer"),
        ([os.fsdecode(b"\xff\n.png")], r"\udcff\n.png is empty"),
        (["pair"], "left_1.png beside right_1.png"),
        (["dark"], "--bits 12"),
        (["dark", "--bits", "10"], "--bits 10: dark/1.png"),
        (["dark", "--bits", "8"], "--bits: expected 9 to 16"),
        (["frame.png", "--bits", "12"], "--bits 12: frame.png"),
        (["frame.png", "--right", "more"], "--right: expected 1 images"),
        (["frame.png", "--rate", "0"], "--rate"),
        (["frame.png", "--calibration", "none.toml"], "none.toml"),
        (["frame.png", "--calibration", "ears.toml"], "ears"),
        (["frame.png", "--policy", "none.onnx"], "none.onnx"),
        (["frame.png", "--policy", "nearness.onnx"], "--preset paper"),
        (["frame.png", "--calibration", "narrow.toml", *SEES], "lens.fov_rad"),
        (["frame.png", "--right", "frame.png", *SEES], "--right"),
        (["frame.png", "--policy", "racer.onnx"], "--max-speed-mps"),
    ],
)
def test_what_cannot_work_is_said_in_one_line(
    files: Path, words: list[str], expected: str, port: int, capfd: pytest.CaptureFixture[str]
):
    try:
        status = main(["camera", *words, "--port", str(port)])
    except SystemExit as end:
        status = end.code
    said = capfd.readouterr().err
    assert status == 2
    assert expected in said
    assert len(said.strip().splitlines()) == 1


@pytest.fixture
def port() -> int:
    """A port that nobody listens on."""
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return int(listener.getsockname()[1])
