"""A robot and a controller on two machines: who hears the robot's scans, as a client and as a peer?

    python tests/campaigns/two_machines.py [--scans 500] [--json]

Two network namespaces stand for the machines, joined by a cable. In one there are a router as
rmw_zenohd starts it and a node as rmw_zenoh opens it, which listens on its own machine only; it
scans 50 times a second and hears twists. In the other one is `reflexarc ros2 --wire rmw --zenoh`
with the router's address. Zenoh lets the one with the greater identifier connect, so both orders
are tried. It takes a minute, and needs root and `ip netns`: where that is not permitted it says so.
"""

import argparse
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1]))

from reflexarc_runtime.ros2.ros_types import LASER_SCAN, TWIST
from reflexarc_sim_bridge.body.ros2.key_expressions import rmw_key
from support.ros2_robot import Robot, rmw_node, rmw_router  # found by the line above

ROBOT, BRAIN = "reflexarc-robot", "reflexarc-brain"
ROBOT_IP, BRAIN_IP = "10.123.45.1", "10.123.45.2"
PORT = 7447
LOW, HIGH = "1", "f" * 32
"""Identifiers: the node's is between them."""
NODE_ID = "8" * 32
SCAN_KEY, WHEEL_KEY = rmw_key(0, "/scan", LASER_SCAN), rmw_key(0, "/cmd_vel", TWIST)
LIMITS = ("--max-linear", "1", "--max-lateral", "1", "--max-angular", "1")


@contextmanager
def two_machines() -> Iterator[None]:
    """Two network namespaces and a cable between them."""
    for name in (ROBOT, BRAIN):
        _ip("netns", "add", name)
    try:
        _ip(
            "link",
            "add",
            "reflex0",
            "netns",
            ROBOT,
            "type",
            "veth",
            "peer",
            "reflex1",
            "netns",
            BRAIN,
        )
        for name, link, address in ((ROBOT, "reflex0", ROBOT_IP), (BRAIN, "reflex1", BRAIN_IP)):
            _ip("-n", name, "address", "add", f"{address}/24", "dev", link)
            _ip("-n", name, "link", "set", link, "up")
            _ip("-n", name, "link", "set", "lo", "up")
        yield
    finally:
        for name in (ROBOT, BRAIN):
            _ip("netns", "delete", name)


def _ip(*words: str) -> None:
    subprocess.run(["ip", *words], check=True, capture_output=True, text=True)


def trial(scans: int, mode: str, identifier: str, folder: Path) -> dict[str, Any]:
    """How many scans the bridge had, and how many twists the robot, on two machines."""
    file = folder / f"{mode}.json5"
    listen = "" if mode == "client" else f'listen: {{ endpoints: ["tcp/{BRAIN_IP}:0"] }}, '
    file.write_text(
        f'{{ mode: "{mode}", id: "{identifier}", {listen}'
        f"scouting: {{ multicast: {{ enabled: false }} }}, "
        f'connect: {{ endpoints: ["tcp/{ROBOT_IP}:{PORT}"] }} }}'
    )
    words = ["ros2", "--wire", "rmw", "--zenoh", str(file), "--no-companion", "--json", *LIMITS]
    words += ["--allow-open"] * (mode == "peer")  # which listens in plain TCP
    here = [sys.executable, str(Path(__file__)), "--robot", str(scans)]
    with _inside(ROBOT, here) as robot:
        assert robot.stdout is not None  # it was asked for as a pipe
        assert robot.stdout.readline() == "ready\n"
        with _inside(BRAIN, [sys.executable, "-m", "reflexarc", *words], folder) as bridge:
            said, _ = robot.communicate(timeout=60 + scans * 0.03)
            bridge.send_signal(signal.SIGINT)
            account = json.loads(bridge.communicate(timeout=30)[0].splitlines()[-1])
    told = json.loads(said.splitlines()[-1])
    return {
        "mode": mode,
        "identifier": "smaller" if identifier == LOW else "greater",
        "scans": account["scans"],
        "twists": told["twists"],
        "said": account["twists"],
    }


@contextmanager
def _inside(
    name: str, words: list[str], folder: Path | None = None
) -> Iterator[subprocess.Popen[str]]:
    """A process on one of the machines."""
    process = subprocess.Popen(
        ["ip", "netns", "exec", name, *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        cwd=folder,
    )
    try:
        yield process
    finally:
        if process.poll() is None:
            process.kill()
        process.wait()


def be_robot(scans: int) -> None:
    """The robot's machine: router, node, scans; it says at the end what it was told."""
    with rmw_router(PORT), rmw_node(PORT, NODE_ID) as session:
        body = Robot(session, SCAN_KEY, WHEEL_KEY, stamped=False)
        wheels = session.declare_subscriber(WHEEL_KEY, body.hear)
        print("ready", flush=True)
        time.sleep(6.0)  # the bridge starts and finds the robot, or does not
        scanner = threading.Thread(target=body.scan, kwargs={"count": scans})
        body.scanning.set()
        scanner.start()
        scanner.join()
        time.sleep(0.5)
        wheels.undeclare()
    print(json.dumps({"twists": len(body.told)}))


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scans", type=int, default=500)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--robot", type=int, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.robot is not None:
        be_robot(arguments.robot)
        return
    if os.geteuid() != 0:
        sys.exit("two_machines: skipped: network namespaces need root")
    try:
        rows = _rows(arguments.scans)
    except (OSError, subprocess.CalledProcessError) as error:
        reason = getattr(error, "stderr", "") or str(error)
        sys.exit(f"two_machines: skipped: `ip netns` is not permitted here: {reason.strip()}")
    if arguments.json:
        print(json.dumps(rows))
        return
    print(f"{'mode':<8}{'its Zenoh id':<14}{'scans heard':>12}{'twists heard by the robot':>27}")
    for row in rows:
        heard = f"{row['scans']} of {arguments.scans}"
        print(f"{row['mode']:<8}{row['identifier']:<14}{heard:>12}{row['twists']:>27}")


def _rows(scans: int) -> list[dict[str, Any]]:
    with two_machines(), TemporaryDirectory() as folder:
        return [
            trial(scans, mode, identifier, Path(folder))
            for mode in ("peer", "client")
            for identifier in (LOW, HIGH)
        ]


if __name__ == "__main__":
    main()
