"""A terminal that is closed: every command that serves the bus ends as it does at Ctrl-C."""

import json
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec, Shading
from support.images import bar, write_image
from support.policies import exported
from support.processes import PATIENCE_S, Process, finished, said_line, started

GOLDEN = Path(__file__).parents[1] / "golden" / "nominal.mcap"
HANG_UPS = pytest.mark.parametrize("number", [signal.SIGHUP, signal.SIGQUIT])


def camera_words(folder: Path) -> tuple[object, ...]:
    image, policy = folder / "bar.png", folder / "colours.onnx"
    write_image(image, bar(16))
    retina = RetinaSpec(rays=4, shading=Shading.COLOUR)
    policy.write_bytes(exported(replace(PolicyContract(), retina=retina)))
    return "camera", image, "--policy", policy


SERVERS: dict[str, tuple[Callable[[Path, Path], tuple[object, ...]], str, str]] = {
    "sim": (lambda policy, _: ("sim", "--policy", policy), "reflexarc sim:", "distance_m"),
    "play": (lambda _, __: ("play", GOLDEN, "--loop"), "reflexarc play:", "messages"),
    "camera": (lambda _, folder: camera_words(folder), "reflexarc camera:", "retinas"),
}
"""By command: its words, the line that says that it serves, and a field of its report."""


@HANG_UPS
@pytest.mark.parametrize("name", SERVERS)
def test_a_hang_up_ends_it_with_its_report(
    policy: Path, port: int, tmp_path: Path, name: str, number: signal.Signals
):
    words, line, field = SERVERS[name]
    with started(*words(policy, tmp_path), "--port", port, "--json", cwd=tmp_path) as process:
        said_line(process, line)
        assert field in finished(process, number)


def test_under_nohup_a_body_goes_on(policy: Path, port: int, tmp_path: Path):
    words = ["nohup", sys.executable, "-m", "reflexarc", "sim", "--policy", policy, "--json"]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    command = [str(word) for word in (*words, "--port", port)]
    process: Process = subprocess.Popen(command, text=True, cwd=tmp_path, **pipes)
    try:
        said_line(process, "reflexarc sim:")
        process.send_signal(signal.SIGHUP)
        time.sleep(0.5)
        assert process.poll() is None
        process.send_signal(signal.SIGTERM)
        said, complaint = process.communicate(timeout=PATIENCE_S)
        assert process.returncode == 0, complaint
        assert json.loads(said.splitlines()[-1])["steps"] > 0
    finally:
        process.kill()
