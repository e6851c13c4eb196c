"""What a target machine has: no torch, and the wheel without extras."""

import os
import signal
import subprocess
import sys
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ROOMS = ("reflexarc", "reflexarc_runtime", "reflexarc_logs", "reflexarc_sim_bridge")


def test_runtime_logs_and_bridge_never_load_torch():
    code = """
import importlib, pkgutil, sys
rooms = "runtime", "logs", "sim_bridge", "pictures"
for room in ("reflexarc", *(f"reflexarc_{room}" for room in rooms)):
    package = importlib.import_module(room)
    for module in pkgutil.walk_packages(package.__path__, room + "."):
        if any(part in module.name for part in ("demo", "progress", "__main__")):
            continue
        importlib.import_module(module.name)
loaded = {name.partition(".")[0] for name in sys.modules}
assert "reflexarc_runtime" in loaded and "zenoh" in loaded and "numba" in loaded
print(sorted(loaded & {"torch", "reflexarc_trainer"}))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_the_runtime_loads_neither_numba_nor_plotting():
    code = """
import sys
import reflexarc_runtime.loop.node, reflexarc_runtime.bus, reflexarc_runtime.policy.policy
import reflexarc_logs.recording.recorder, reflexarc_logs.replaying.replay
import reflexarc.commands.drive.run, reflexarc.main
loaded = {name.partition(".")[0] for name in sys.modules}
print(sorted(loaded & {"numba", "gymnasium", "matplotlib", "torch"}))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("wrong", [["--preset", "none"], ["--seed", "-1"], ["--world", "none"]])
def test_a_wrong_run_is_refused_before_torch_is_loaded(wrong: list[str], tmp_path: Path):
    code = """
import sys
from reflexarc.main import main
try:
    status = main(sys.argv[1:])
except SystemExit as end:
    status = end.code
print(status, "torch" in sys.modules)
"""
    train = ["train", "--out", str(tmp_path), *wrong]
    done = subprocess.run([sys.executable, "-c", code, *train], capture_output=True, text=True)
    assert done.stdout.strip() == "2 False", done.stderr


@pytest.fixture(scope="module")
def target(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A fresh environment with the wheel and its base dependencies; its bin folder."""
    folder = tmp_path_factory.mktemp("target")
    build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(folder)]
    subprocess.run([*build, str(ROOT)], check=True, capture_output=True)
    (wheel,) = folder.glob("reflexarc-*.whl")
    venv.create(folder / "env", with_pip=True)
    pip = [str(folder / "env/bin/python"), "-m", "pip", "install", "--quiet"]
    constraints = ["-c", str(ROOT / "constraints.txt")]
    done = subprocess.run(
        [*pip, *constraints, str(wheel)], capture_output=True, text=True, check=False
    )
    if done.returncode != 0 and "onnectionError" in done.stderr:
        pytest.skip("no package index can be reached from here")
    assert done.returncode == 0, done.stderr
    return folder / "env/bin"


def test_the_wheel_without_extras_runs_and_replays(
    target: Path, policy: Path, port: int, tmp_path: Path
):
    log = tmp_path / "drive.mcap"
    clean = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    command = str(target / "reflexarc")
    body = subprocess.Popen(
        [sys.executable, "-m", "reflexarc", "sim", "--policy", str(policy), "--port", str(port)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        words = ["run", str(policy), "--port", str(port), "--record", str(log), "--ticks", "200"]
        ran = subprocess.run(
            [command, *words], capture_output=True, text=True, env=clean, check=False
        )
        assert ran.returncode == 0, ran.stderr
    finally:
        body.send_signal(signal.SIGINT)
        body.wait()
    again = subprocess.run(
        [command, "replay", str(log)], capture_output=True, text=True, env=clean, check=False
    )
    assert again.returncode == 0, again.stderr
    listed = subprocess.run(
        [str(target / "python"), "-m", "pip", "list"], capture_output=True, text=True, check=True
    )
    assert "torch" not in listed.stdout
    assert "numba" not in listed.stdout
    refused = subprocess.run(
        [command, "train"], capture_output=True, text=True, env=clean, check=False
    )
    assert refused.returncode == 2
    assert "reflexarc[train]" in refused.stderr
