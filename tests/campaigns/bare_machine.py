"""What the product touches on a machine, and that it runs where next to nothing can be touched.

    python tests/campaigns/bare_machine.py [--seconds 30] [--part trace|commands|tests]

As root, with `strace` and `unshare`.

- trace: `reflexarc run`, on each backend, under strace for so many seconds: nothing but loopback is
  spoken to, nothing but its recording is written.
- commands: every command once, in a mount namespace of its own, where the home folder, `/var` and
  `/dev/shm` cannot be written and `/tmp` is the only place left. `worlds check` finds no place for
  compiled code either; the others keep it in the scratch folder, or they would take an hour.
- tests: the tests of the runtime and of the logs in such a namespace.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tests"))

from reflexarc_runtime.contract.contract import PolicyContract  # noqa: E402  # below its place
from support.policies import exported  # noqa: E402

GOLDEN = ROOT / "tests" / "golden" / "nominal.mcap"
REFLEXARC = (sys.executable, "-m", "reflexarc")
PORT = 7931
WRITES = re.compile(r"O_(?:WRONLY|RDWR|CREAT)|^\S+\s+(?:mkdir|rename|unlink|link|symlink)")
CALL = re.compile(r'"((?:[^"\\]|\\.)*)"')
NOWHERE = ("/dev/null", "/dev/tty", "/proc/self/", "/proc/thread-self/", "/dev/urandom")
HERE = ("127.0.0.1", "AF_UNIX", "AF_NETLINK", '"0.0.0.0"', '"::1"', '"::"')
READ_ONLY = """
set -e
for place in /root /home /var /dev/shm "$ROOT"; do
    if [ -d "$place" ]; then mount --bind "$place" "$place"; mount -o remount,bind,ro "$place"; fi
done
cd "$1"
shift
exec "$@"
"""


@dataclass(frozen=True)
class Row:
    """One line of the table."""

    what: str
    holds: bool
    seen: str


def main() -> int:
    """Try the parts and print the table."""
    given = _arguments()
    parts = {"trace": _traced, "commands": _commands, "tests": _tests}
    missed = 0
    with tempfile.TemporaryDirectory() as name:
        scratch = Path(name)
        (scratch / "policy.onnx").write_bytes(exported(PolicyContract(), seed=5))
        for part, rows in parts.items():
            if given.part in ("", part):
                for row in rows(scratch, given.seconds):
                    missed += not row.holds
                    print(
                        f"{'ok   ' if row.holds else 'WRONG'}  {row.what}: {row.seen}", flush=True
                    )
    return int(missed > 0)


def _traced(scratch: Path, seconds: float) -> Iterator[Row]:
    for backend in ("numpy", "onnxruntime"):
        trace, log = scratch / f"{backend}.trace", scratch / f"{backend}.mcap"
        words = ("run", scratch / "policy.onnx", "--backend", backend, "--record", log)
        ticks = round(seconds * PolicyContract().rate_hz)
        strace = ("strace", "-f", "-qq", "-e", "trace=network,%file", "-o", trace)
        done = _ran([*strace, *REFLEXARC, *words, "--ticks", ticks, "--port", PORT], scratch, {})
        lines = trace.read_text(errors="replace").splitlines()
        yield Row(f"run on {backend}", done.returncode == 0, f"status {done.returncode}")
        abroad = [line for line in _peers(lines) if not any(place in line for place in HERE)]
        yield Row(f"run on {backend}, peers", not abroad, _counted(abroad, _peers(lines)))
        written = _written(lines)
        strange = sorted(path for path in written if not path.startswith((str(log), *NOWHERE)))
        yield Row(f"run on {backend}, files", not strange, _counted(strange, [*written]))


def _peers(lines: list[str]) -> list[str]:
    """Calls that name an address."""
    return [line for line in lines if "sa_family" in line]


def _written(lines: list[str]) -> set[str]:
    """Files that were opened to be written, made, renamed or removed."""
    changing = [line for line in lines if WRITES.search(line) and " = -1 " not in line]
    return {path for line in changing for path in CALL.findall(line)[:1]}


def _commands(scratch: Path, _seconds: float) -> Iterator[Row]:
    policy, serve = scratch / "policy.onnx", ("--port", PORT)
    log = scratch / "drive.mcap"
    shutil.copy(GOLDEN, log)
    (scratch / "lidar.txt").write_text("FLASER 3 1.0 1.1 1.2 0 0 0 0 0 0 0 host 0\n")
    commands: dict[str, tuple[object, ...]] = {
        "--help": ("--help",),
        "info, policy": ("info", policy),
        "info, log": ("info", log),
        "run": ("run", policy, *serve, "--ticks", 50, "--record", "run.mcap"),
        "run, onnxruntime": ("run", policy, *serve, "--ticks", 50, "--backend", "onnxruntime"),
        "replay": ("replay", log),
        "recover": ("recover", log, "-o", "recovered.mcap"),
        "cut": ("cut", log, "--from", 1, "--to", 40, "-o", "cut.mcap"),
        "render": ("render", log, "-o", "drive.png"),
        "import": ("import", "carmen", "lidar.txt", "-o", "lidar.mcap"),
        "play": ("play", log, *serve, "--speed", 100),
        "record": ("record", "-o", "recorded.mcap", *serve, "--seconds", 1),
        "worlds list": ("worlds", "list"),
        "worlds show": ("worlds", "show", "reference-1"),
        "worlds check": ("worlds", "check", "plane", "--seeds", 2),
        "sim": ("sim", "--policy", policy, *serve),
        "ros2": ("ros2", *serve, "--max-linear", 1, "--max-lateral", 1, "--max-angular", 1),
        "arm": ("arm", *serve, "--patience", 1),
        "stop": ("stop", *serve, "--patience", 1),
        "reset": ("reset", *serve, "--patience", 1),
        "release": ("release", *serve, "--patience", 1),
        "baselines list": ("baselines", "list"),
        "baselines export": ("baselines", "export", "braitenberg-2b", "-o", "b.onnx"),
        "train": ("train", "--steps", 2000, "--out", "trained"),
        "export": ("export", "trained/checkpoint.npz", "-o", "exported.onnx"),
        "evaluate": ("evaluate", policy, "--agents", 16, "--steps", 20),
        "study": ("study", "--list"),
    }
    nobody = {"arm": 1, "stop": 1, "reset": 1, "release": 1}
    for name, words in commands.items():
        begun_s = time.monotonic()
        kept = {} if name == "worlds check" else {"NUMBA_CACHE_DIR": str(scratch / "compiled")}
        done = _bare([*REFLEXARC, *words], scratch, kept, ends=name in ("sim", "ros2"))
        holds = done.returncode == nobody.get(name, 0) and "Traceback" not in done.stderr
        said = (done.stderr.strip().splitlines() or [""])[-1][:160]
        yield Row(
            name, holds, f"status {done.returncode}, {time.monotonic() - begun_s:.0f} s; {said}"
        )


def _tests(scratch: Path, _seconds: float) -> Iterator[Row]:
    for room in ("runtime", "logs"):
        words = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-n", "2"]
        done = _bare(
            [*words, "--basetemp", scratch / f"pytest-{room}", ROOT / "tests" / room], scratch, {}
        )
        said = done.stdout.strip().splitlines() or [done.stderr.strip()]
        failed = [line for line in said if line.startswith(("FAILED", "ERROR"))]
        yield Row(f"tests/{room}", done.returncode == 0, "; ".join([said[-1], *failed]))


def _bare(
    words: list[object], scratch: Path, more: Mapping[str, str], *, ends: bool = False
) -> "subprocess.CompletedProcess[str]":
    """Run a command to its end where only the scratch folder can be written.

    Args:
        ends: it serves until it is told to end: after 20 s.
    """
    limit = ("timeout", "--signal=INT", "--preserve-status", "20" if ends else "900")
    own = ("unshare", "--mount", "sh", "-c", READ_ONLY, "sh", scratch, *limit)
    settings = {"ROOT": str(ROOT), "PYTHONDONTWRITEBYTECODE": "1", "HOME": "/root"}
    return _ran([*own, *words], scratch, {**settings, **more})


def _ran(
    words: list[object], folder: Path, settings: Mapping[str, str]
) -> "subprocess.CompletedProcess[str]":
    away = ("NUMBA_CACHE_DIR", "ORT_DISABLE_TELEMETRY", "MPLCONFIGDIR")
    inherited = {name: value for name, value in os.environ.items() if name not in away}
    return subprocess.run(
        [str(word) for word in words],
        cwd=folder,
        env={**inherited, **settings},
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )


def _counted(strange: list[str], all_of_them: list[str]) -> str:
    return "; ".join(strange[:4]) or f"{len(all_of_them)}, all of them its own"


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--seconds", type=float, default=30.0, help="how long `run` is traced")
    parser.add_argument("--part", default="", choices=("", "trace", "commands", "tests"))
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
