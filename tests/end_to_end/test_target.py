"""What a target machine has: no torch, and the wheel without extras."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import venv
import zipfile
from email.parser import Parser
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
        if any(part in module.name for part in ("demo", "progress", "__main__", "rerun_canvas")):
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


WATCHED = """
import sys
names = []
sys.addaudithook(lambda event, args: names.append(args[0]) if event == "socket.getaddrinfo" else 0)
from reflexarc_runtime.policy.policy import load_policy
load_policy(sys.argv[1], sys.argv[2])
print("onnxruntime" in sys.modules, names)
"""


@pytest.mark.parametrize("backend", ["numpy", "onnxruntime"])
def test_a_policy_is_loaded_without_a_word_to_anybody_nor_a_file_at_home(
    policy: Path, tmp_path: Path, backend: str
):
    """What onnxruntime itself looks up, no hook of Python's sees; strace does, below."""
    surroundings = {k: v for k, v in os.environ.items() if not k.startswith("ORT_")}
    words = [sys.executable, "-c", WATCHED, str(policy), backend]
    done = subprocess.run(
        words,
        env={**surroundings, "HOME": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path / "cache")},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.strip() == f"{backend == 'onnxruntime'} []"
    assert not [*tmp_path.rglob("*")]


@pytest.mark.parametrize("command", ["info", "replay"])
def test_commands_on_logs_never_load_onnxruntime(command: str):
    log = ROOT / "tests" / "golden" / "nominal.mcap"
    words = [sys.executable, "-X", "importtime", "-m", "reflexarc", command, str(log)]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    assert "numpy" in done.stderr
    assert "onnxruntime" not in done.stderr


@pytest.mark.skipif(shutil.which("strace") is None, reason="strace is not installed")
@pytest.mark.parametrize("backend", ["numpy", pytest.param("onnxruntime", marks=pytest.mark.long)])
def test_a_runtime_speaks_to_this_machine_alone_and_writes_its_log_alone(
    policy: Path, port: int, tmp_path: Path, backend: str
):
    trace, log = tmp_path / "trace", tmp_path / "drive.mcap"
    strace = ["strace", "-f", "-qq", "-e", "trace=network,openat", "-o", str(trace)]
    words = ["run", policy, "--backend", backend, "--record", log, "--port", port, "--ticks", 100]
    surroundings = {k: v for k, v in os.environ.items() if not k.startswith("ORT_")}
    subprocess.run(
        [*strace, sys.executable, "-B", "-m", "reflexarc", *map(str, words)],
        env={**surroundings, "HOME": str(tmp_path)},
        capture_output=True,
        check=True,
    )
    lines = trace.read_text(errors="replace").splitlines()
    spoken_to = [line for line in lines if "AF_INET" in line and "sa_family" in line]
    assert spoken_to
    assert not [line for line in spoken_to if not re.search(r'"(127\.0\.0\.1|0\.0\.0\.0)"', line)]
    written = [line for line in lines if re.search("O_WRONLY|O_RDWR|O_CREAT", line)]
    assert {path for line in written for path in re.findall(r'"([^"]*)"', line)} <= {
        *(f"{log}{suffix}" for suffix in ("", ".partial")),
        "/dev/null",
    } | {path for line in written if " = -1 " in line for path in re.findall(r'"([^"]*)"', line)}


@pytest.mark.skipif(os.geteuid() != 0, reason="only root may make a mount namespace")
@pytest.mark.parametrize("by_file", [False, True])
def test_neither_shared_memory_nor_locked_memory_is_needed(
    policy: Path, port: int, tmp_path: Path, by_file: bool
):
    file = tmp_path / "zenoh.json5"
    file.write_text(
        f'{{listen: {{endpoints: ["tcp/127.0.0.1:{port}"]}}, '
        "scouting: {multicast: {enabled: false}}}"
    )
    script = 'mount -t tmpfs -o ro tmpfs /dev/shm && ulimit -l 0 && exec "$@"'
    own = ["unshare", "--mount", "setpriv", "--bounding-set=-ipc_lock", "sh", "-c", script, "sh"]
    where = ["--zenoh", file] if by_file else ["--port", port]
    words = ["run", policy, *where, "--ticks", 5]
    done = subprocess.run(
        [*own, sys.executable, "-m", "reflexarc", *map(str, words)], capture_output=True, text=True
    )
    if "unshare failed" in done.stderr:
        pytest.skip("no namespace can be made here")
    assert done.returncode == 0, done.stderr


def test_a_program_is_told_where_the_recording_is(policy: Path, port: int, tmp_path: Path):
    words = ["run", policy, "--port", port, "--ticks", 3, "--record", "[red] µ.mcap", "--json"]
    done = subprocess.run(
        [sys.executable, "-m", "reflexarc", *map(str, words)],
        env={**os.environ, "PYTHONIOENCODING": "ascii"},
        capture_output=True,
        text=True,
        cwd=tmp_path,
        check=True,
    )
    assert json.loads(done.stdout)["recording"] == "[red] µ.mcap"
    assert (tmp_path / "[red] µ.mcap").exists()


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
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, as it is built for a target."""
    folder = tmp_path_factory.mktemp("wheel")
    build = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(folder)]
    subprocess.run([*build, str(ROOT)], check=True, capture_output=True)
    (path,) = folder.glob("reflexarc-*.whl")
    return path


def test_every_package_of_the_wheel_says_that_it_is_typed(wheel: Path):
    names = zipfile.ZipFile(wheel).namelist()
    packages = {name.partition("/")[0] for name in names if ".dist-info" not in name}
    assert len(packages) == 7
    assert {f"{package}/py.typed" for package in packages} <= {*names}


def test_every_requirement_of_the_wheel_ends_below_what_is_not_tested(wheel: Path):
    archive = zipfile.ZipFile(wheel)
    (place,) = (name for name in archive.namelist() if name.endswith("/METADATA"))
    wanted = Parser().parsestr(archive.read(place).decode()).get_all("Requires-Dist", [])
    dev = [each for each in wanted if "extra == 'dev'" in each]
    assert [each for each in wanted if "<" not in each and each not in dev] == [
        each for each in wanted if each.startswith("reflexarc[") and each not in dev
    ]
    assert len(wanted) > 20


@pytest.fixture(scope="module")
def target(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A fresh environment with the wheel and its base dependencies; its bin folder."""
    folder = tmp_path_factory.mktemp("target")
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
