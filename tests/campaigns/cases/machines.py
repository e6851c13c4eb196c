"""Machines as they are."""

import json
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

from cases.case import Case, Outcome, Said, Stage
from cases.names import CASES as NAMES
from reflexarc_runtime.contract.contract import PolicyContract
from support.policies import exported
from support.processes import finished, reflexarc, said_line, started
from support.ros2_drives import FAST_ENOUGH, driving
from support.ros2_robot import robot

GOLDEN = Path(__file__).parents[2] / "golden" / "nominal.mcap"
TELEMETRY = "ORT_DISABLE_TELEMETRY"
NO_ID = ("unshare", "--user", "--map-user=54321", "--map-group=54321")
"""A user who is in no list; what root owns he may still read."""
LOOPBACK = "127.0.0.1", "AF_UNIX", "AF_NETLINK", 'inet_addr("0.0.0.0")', '"::1"'


def policy(stage: Stage) -> Path:
    """A policy of random weights."""
    path = stage.scratch / "policy.onnx"
    path.write_bytes(exported(PolicyContract(), seed=5))
    return path


def port() -> int:
    """A port that nobody listens on."""
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return int(listener.getsockname()[1])


def run_words(stage: Stage, *words: object) -> tuple[object, ...]:
    """`run` for 20 ticks."""
    return ("run", policy(stage), "--ticks", 20, "--port", port(), *words)


def ended(said: Said, *seen: str, status: int = 0) -> Outcome:
    """Whether a command ended so, without a traceback, and said all this."""
    holds = said.status == status and not said.has_traceback
    missing = [words for words in seen if words not in said.everything]
    return Outcome(holds and not missing, f"status {said.status}, missing {missing or 'nothing'}")


def hang_up(stage: Stage) -> Outcome:
    """`run --record` and `ros2`, while it drives, end at a hang-up as they do at Ctrl-C."""
    log = stage.scratch / "hang.mcap"
    words = ("run", policy(stage), "--record", log, "--port", port(), "--json")
    with started(*words) as process:
        said_line(process, "watchdog")
        time.sleep(1.0)
        report = finished(process, signal.SIGHUP)
    with driving(policy(stage), port()) as drive:
        finished(drive.bridge, signal.SIGHUP)
        time.sleep(0.5)
        stands = all(word.is_standstill for word in drive.body.told[-10:])
    holds = log.exists() and report["verdicts"].get("STOPPED") == 1 and stands
    return Outcome(holds, f"log {log.exists()}, verdicts {report['verdicts']}, stands {stands}")


def nohup(stage: Stage) -> Outcome:
    """Under `nohup` a hang-up changes nothing."""
    words = [*run_words(stage), "--json"]
    command = ["nohup", sys.executable, "-m", "reflexarc", *map(str, words)]
    command[command.index("--ticks") + 1] = "150"
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(command, text=True, cwd=stage.scratch, **pipes) as process:  # type: ignore[call-overload]  # a mapping of one type
        said_line(process, "watchdog")
        process.send_signal(signal.SIGHUP)
        report = json.loads(process.communicate(timeout=60)[0].splitlines()[-1])
    return Outcome(report["ticks"] >= 150, f"{report['ticks']} ticks")


def empty_home(stage: Stage) -> Outcome:
    """`info` of a log, and a policy on each backend, in an empty home: nothing is left there."""
    os.environ.pop(TELEMETRY, None)
    home = stage.scratch / "home"
    home.mkdir()
    said = [
        stage.reflexarc("info", GOLDEN, HOME=str(home)),
        *(
            stage.reflexarc(*run_words(stage, "--backend", name), HOME=str(home))
            for name in ("numpy", "onnxruntime")
        ),
    ]
    left = sorted(str(path.relative_to(home)) for path in home.rglob("*") if path.is_file())
    holds = all(each.status == 0 for each in said) and not left
    return Outcome(holds, f"left: {left or 'nothing'}")


def no_name_looked_up(stage: Stage) -> Outcome:
    """Under strace `run` speaks to this machine only."""
    os.environ.pop(TELEMETRY, None)
    trace = stage.scratch / "trace"
    words = [*run_words(stage, "--backend", "onnxruntime")]
    words[words.index(20)] = 250
    strace = ("strace", "-f", "-qq", "-e", "trace=network", "-o", trace)
    said = stage.command(*strace, sys.executable, "-m", "reflexarc", *words)
    calls = [line for line in trace.read_text(errors="replace").splitlines() if "sa_family" in line]
    abroad = [line for line in calls if not any(word in line for word in LOOPBACK)]
    return Outcome(said.status == 0 and not abroad, f"status {said.status}, abroad {abroad[:3]}")


def no_shared_memory(stage: Stage) -> Outcome:
    """`/dev/shm` that cannot be written."""
    words = [str(word) for word in run_words(stage)]
    script = 'mount -t tmpfs -o ro tmpfs /dev/shm && exec "$@"'
    own = ("unshare", "--mount", "sh", "-c", script, "sh")
    return ended(stage.command(*own, sys.executable, "-m", "reflexarc", *words), "ticks")


def no_locked_memory(stage: Stage) -> Outcome:
    """No memory may be locked, nor may the process ask for more."""
    words = [str(word) for word in run_words(stage)]
    less = ("setpriv", "--bounding-set=-ipc_lock", "--inh-caps=-ipc_lock")
    script = ("sh", "-c", 'ulimit -l 0 && exec "$@"', "sh")
    return ended(stage.command(*less, *script, sys.executable, "-m", "reflexarc", *words), "ticks")


def no_user(stage: Stage) -> Outcome:
    """A user without an entry, a name or a home."""
    body = ("sim", "--steps", 3, "--policy", policy(stage), "--port", port())
    gone = ("env", "-u", "HOME", "-u", "NUMBA_CACHE_DIR", *NO_ID, sys.executable, "-m", "reflexarc")
    command = [str(word) for word in (*gone, *body)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(command, text=True, cwd=stage.scratch, **pipes) as process:  # type: ignore[call-overload]  # a mapping of one type
        line = said_line(process, "seed")
        process.send_signal(signal.SIGINT)
        _, complaint = process.communicate(timeout=240)
    holds = process.returncode == 0 and "Traceback" not in complaint
    return Outcome(holds, f"status {process.returncode}, {line.strip()}")


def ascii_only(stage: Stage) -> Outcome:
    """A stream that takes ASCII only."""
    words = run_words(stage, "--record", "x.mcap")
    return ended(stage.reflexarc(*words, PYTHONIOENCODING="ascii"), "lateness", "x.mcap")


def width_0(stage: Stage) -> Outcome:
    """A terminal of no width."""
    return ended(stage.reflexarc("info", GOLDEN, COLUMNS="0"), "monotonic clock", "/robot0/tick")


def first_line_only(stage: Stage) -> Outcome:
    """A reader that takes the first line."""
    script = f"set -o pipefail; {sys.executable} -m reflexarc info {GOLDEN} | head -1"
    return ended(stage.command("bash", "-c", script), "log")


def recording_named(stage: Stage) -> Outcome:
    """A program asks where the recording is."""
    said = stage.reflexarc(*run_words(stage, "--record", "x.mcap", "--json"))
    recording = json.loads(said.out)["recording"]
    return Outcome(recording == "x.mcap", f"recording: {recording}")


def two_runtimes(stage: Stage) -> Outcome:
    """Two runtimes of one robot: the second is told that the body obeys the first."""
    brain, where = policy(stage), ("--port", port())
    with (
        started("sim", "--policy", brain, *where) as body,
        started("run", brain, *where) as first,
    ):
        said_line(body, "seed")
        said_line(first, "watchdog")
        time.sleep(3.0)
        second = reflexarc("run", brain, *where, "--ticks", 500)
    said = [line for line in second.stderr.splitlines() if "obeys another runtime" in line]
    return Outcome(len(said) == 1, said[0] if said else second.stderr[-200:])


def humble(stage: Stage) -> Outcome:
    """Scans on the keys of ROS 2 Humble beside a bridge that waits for those of Jazzy."""
    key, place = "0/scan/sensor_msgs::msg::dds_::LaserScan_/TypeHashNotSupported", port()
    words = ("ros2", "--wire", "rmw", "--port", place, *FAST_ENOUGH)
    with (
        robot(place, key, "cmd_vel", stamped=False),
        started(*words, cwd=stage.scratch) as bridge,
    ):
        line = said_line(bridge, "waits for scans")
    return Outcome("humble" in line, line.strip()[-200:])


def no_router(stage: Stage) -> Outcome:
    """A bridge alone, as a peer of a bridge's DDS and as a client of a router."""
    said = []
    for wire, words in (("ros2dds", "nobody answers at"), ("rmw", "no Zenoh router on")):
        flags = ("--wire", wire, "--port", port(), *FAST_ENOUGH)
        with started("ros2", *flags, cwd=stage.scratch) as bridge:
            said.append(said_line(bridge, words).strip())
    return Outcome(True, "; ".join(said)[-300:])


CASES: tuple[Case, ...] = (
    Case("environment", "hang-up", "safe command, finished log, status 0", hang_up),
    Case("environment", "hang-up under nohup", "it goes on", nohup),
    Case("environment", "onnxruntime, an empty HOME", "no file", empty_home),
    Case("environment", "onnxruntime, strace", "no name looked up", no_name_looked_up),
    Case("environment", "/dev/shm read-only", "runs", no_shared_memory),
    Case("environment", "no locked memory", "runs", no_locked_memory),
    Case("environment", "no passwd entry, no HOME", "runs", no_user),
    Case("environment", "ASCII output", "status 0", ascii_only),
    Case("environment", "COLUMNS=0", "the text", width_0),
    Case("environment", "| head -1", "status 0", first_line_only),
    Case("environment", "--json", "`recording` names the file", recording_named),
    Case("environment", "two controllers", "the second is warned of", two_runtimes),
    Case("environment", "ROS 2 Humble", "heard, or said", humble),
    Case("environment", "no router", "said after some seconds", no_router),
    *NAMES,
)
