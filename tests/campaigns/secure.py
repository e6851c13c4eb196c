"""A robot on a second machine, from docs/secure.md alone: driven, attacked, logged, replayed.

    python tests/campaigns/secure.py [--seconds 15] [--json]

Two network namespaces stand for the machines, joined by a cable. What an owner types is counted,
and is what the page says. Then strangers on the second machine's side try the robot's door. It
takes two minutes, and needs root and `ip netns`: where that is not permitted it says so. Exit
status 1: a door was open, or something did not work. Exit status 2: the machine did not let the
runtime run, which its own watchdog then ended; nothing is shown.
"""

import argparse
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1]))

from reflexarc.securing.secured_robot import SecuredRobot
from reflexarc.securing.security_folder import make_folder
from reflexarc_runtime.contract.contract import PolicyContract
from support.policies import exported  # found by the line above
from support.processor_account import Waits

ROBOT, BRAIN = "reflexarc-body", "reflexarc-desk"
ROBOT_IP, BRAIN_IP = "10.123.46.1", "10.123.46.2"
PORT = 7447
PATIENCE_S = 90.0
TIMER_NS = 650_000_000
"""The kernel's timer ends a runtime whose loop was not there for so long."""
LET_WAIT_MS = 300.0
"""Who waited longer than that for a processor, of those, was ended by the machine."""
SCOUT = """
import json, sys, time, zenoh
config = zenoh.Config()
config.insert_json5("mode", '"peer"')
session = zenoh.open(config)
time.sleep(3.0)
print(len(list(session.info.transports())))
session.close()
"""
"""Zenoh as anybody starts it: it calls by multicast and joins whoever answers."""
SCAN = """
import socket, sys
for port in range(1, 65536):
    with socket.socket() as knocker:
        knocker.settimeout(0.5)
        if knocker.connect_ex((sys.argv[1], port)) == 0:
            print(port)
"""
"""Which TCP ports of the robot anybody reaches."""


@dataclass
class Owner:
    """Types commands, which are counted."""

    folder: Path
    typed: list[str] = field(default_factory=list)
    found: dict[str, Any] = field(default_factory=dict)
    failures: list[str] = field(default_factory=list)
    said: list[str] = field(default_factory=list)
    """What the commands that go on said, for whoever looks for a failure's cause."""
    machine: list[str] = field(default_factory=list)
    """Which of them were ended by their own watchdog, as no processor was given to them."""

    def runs(self, machine: str, *words: object) -> subprocess.CompletedProcess[str]:
        """A command to its end."""
        self.typed.append(" ".join(map(str, words)))
        return quiet(machine, self.folder / machine, *words)

    @contextmanager
    def starts(self, machine: str, *words: object) -> Iterator[subprocess.Popen[str]]:
        """A command that goes on, and is ended by Ctrl-C."""
        self.typed.append(" ".join(map(str, words)))
        process = subprocess.Popen(
            inside(machine, *words),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            cwd=self.folder / machine,
        )
        waits = Waits({"it": process.pid})
        try:
            yield process
        finally:
            waits.end()
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
            try:
                said, _ = process.communicate(timeout=PATIENCE_S)
            except subprocess.TimeoutExpired:
                process.kill()
                said, _ = process.communicate()
            self.said.append(f"{words[1]}, status {process.returncode}: {said.strip()}")
            waited_ms = waits.last_of("it", TIMER_NS) / 1e6
            if process.returncode == -signal.SIGALRM and waited_ms > LET_WAIT_MS:
                self.machine.append(
                    f"{words[1]} was ended by its own watchdog, whose timer in the kernel ran "
                    f"out: it had waited {waited_ms:.0f} ms for a processor"
                )

    def expect(self, what: str, holds: bool, seen: object) -> None:
        """Write down one thing that was to be seen."""
        self.found[what] = seen
        if not holds:
            self.failures.append(f"{what}: {seen}")


def inside(machine: str, *words: object) -> list[str]:
    """A command on one of the machines."""
    own = [str(word) for word in words]
    if own[0] == "reflexarc":
        own = [sys.executable, "-m", *own]
    return ["ip", "netns", "exec", machine, *own]


def quiet(machine: str, cwd: Path, *words: object) -> subprocess.CompletedProcess[str]:
    """A command that nobody counts."""
    return subprocess.run(
        inside(machine, *words), capture_output=True, text=True, timeout=2 * PATIENCE_S, cwd=cwd
    )


@contextmanager
def two_machines() -> Iterator[None]:
    """Two network namespaces and a cable between them, with addresses of their own alone."""
    with ExitStack() as stack:
        for name in (ROBOT, BRAIN):
            _ip("netns", "add", name)
            stack.callback(_ip, "netns", "delete", name)
        ends = ("reflex0", "netns", ROBOT, "type", "veth", "peer", "reflex1", "netns", BRAIN)
        _ip("link", "add", *ends)
        for name, link, address in ((ROBOT, "reflex0", ROBOT_IP), (BRAIN, "reflex1", BRAIN_IP)):
            _ip("-n", name, "address", "add", f"{address}/24", "dev", link)
            _ip("-n", name, "link", "set", link, "up")
            _ip("-n", name, "link", "set", "lo", "up")
            _ip("-n", name, "route", "add", "224.0.0.0/4", "dev", link)
        yield


def _ip(*words: str) -> None:
    subprocess.run(["ip", *words], check=True, capture_output=True, text=True)


def drive(owner: Owner, seconds: float) -> None:
    """What docs/secure.md says, command by command; attacks while the robot drives."""
    desk, robot = owner.folder / BRAIN, owner.folder / ROBOT
    made = owner.runs(BRAIN, "reflexarc", "secure", "init", "keys", "--host", ROBOT_IP)
    owner.expect("init: status", made.returncode == 0, made.returncode)
    owner.runs(BRAIN, "cp", "-p", "keys/body.json5", robot)  # what scp -p does between machines
    keys, zenoh = desk / "keys", "--zenoh keys"
    with ExitStack() as stack:
        for machine, words in (
            (ROBOT, "sim --no-auto-arm --zenoh body.json5"),
            (BRAIN, f"run policy.onnx --no-guard {zenoh}/runtime.json5 --record drive.mcap"),
        ):
            stack.enter_context(owner.starts(machine, "reflexarc", *words.split()))
        arm = f"reflexarc arm {zenoh}/operator.json5 --patience {PATIENCE_S:g}"
        armed = owner.runs(BRAIN, *arm.split())
        owner.expect("arm: status", armed.returncode == 0, armed.stdout.strip() or armed.stderr)
        listen = f"reflexarc record {zenoh}/recorder.json5 -o seen.mcap"
        stack.enter_context(owner.starts(BRAIN, *listen.split()))
        time.sleep(seconds)
        checked = owner.runs(
            BRAIN, "reflexarc", "secure", "check", "keys", "--connect", f"tls/{ROBOT_IP}:{PORT}"
        )
        lines = checked.stdout.splitlines()
        owner.expect("check: status", checked.returncode == 0, checked.returncode)
        owner.expect("check: doors shut", all(x.startswith("shut") for x in lines), len(lines))
        attack(owner, keys)
        stopped = owner.runs(BRAIN, "reflexarc", "stop", "--zenoh", "keys/operator.json5")
        owner.expect("stop: status", stopped.returncode == 0, stopped.stdout.strip())
        time.sleep(1.0)
    replayed = owner.runs(BRAIN, "reflexarc", "replay", "drive.mcap", "seen.mcap")
    owner.expect("replay: status", replayed.returncode == 0, replayed.stdout.strip())


def attack(owner: Owner, keys: Path) -> None:
    """Strangers on the second machine, who know the page as well; nothing here is counted."""
    desk = owner.folder / BRAIN
    other = make_folder(desk / "other", SecuredRobot("robot0", (ROBOT_IP,), PORT, "body", 1.0))
    plain = desk / "plain.json5"
    plain.write_text(
        f'{{ mode: "client", scouting: {{ multicast: {{ enabled: false }} }}, '
        f'connect: {{ endpoints: ["tcp/{ROBOT_IP}:{PORT}"] }} }}'
    )
    bare = quiet(BRAIN, desk, "reflexarc", "stop", "--zenoh", plain)
    owner.expect("a stop in plain TCP: status", bare.returncode == 2, bare.returncode)
    forged = quiet(BRAIN, desk, "reflexarc", "stop", "--zenoh", other.file("operator"))
    owner.expect("a forged operator: status", forged.returncode == 2, forged.stderr.strip()[-120:])
    for role in ("viewer", "recorder"):
        denied = quiet(BRAIN, desk, "reflexarc", "stop", "--zenoh", keys / f"{role}.json5")
        drives = "driving" in denied.stderr
        seen = denied.stderr.strip()
        owner.expect(f"a stop as {role}", denied.returncode == 1 and drives, seen)
    joined = quiet(BRAIN, desk, sys.executable, "-c", SCOUT)
    owner.expect("whom multicast finds", joined.stdout.strip() == "0", joined.stdout.strip())
    ports = quiet(BRAIN, desk, sys.executable, "-c", SCAN, ROBOT_IP).stdout.split()
    owner.expect("TCP ports of the robot", ports == [str(PORT)], ports)


def campaign(folder: Path, seconds: float) -> Owner:
    """Set up, drive, attack, stop, replay."""
    owner = Owner(folder)
    for machine in (ROBOT, BRAIN):
        (folder / machine).mkdir()
    (folder / BRAIN / "policy.onnx").write_bytes(exported(PolicyContract(), seed=5))
    with two_machines():
        drive(owner, seconds)
    owner.expect("commands typed", len(owner.typed) < 10, len(owner.typed))
    return owner


def main() -> int:
    """Run it and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=15.0)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    if os.geteuid() != 0 or shutil.which("ip") is None:
        sys.exit("secure: skipped: network namespaces need root and `ip`")
    try:
        with TemporaryDirectory() as folder:
            owner = campaign(Path(folder), arguments.seconds)
    except subprocess.CalledProcessError as error:
        sys.exit(f"secure: skipped: `ip netns` is not permitted here: {error.stderr.strip()}")
    if arguments.json:
        bad = {"bad": owner.failures, "machine": owner.machine}
        print(json.dumps({"typed": owner.typed, "found": owner.found, **bad}))
    else:
        print(*owner.typed, "", sep="\n")
        print(*(f"{what:<32}{seen}" for what, seen in owner.found.items()), sep="\n")
        if owner.failures:
            print(*(f"WRONG: {words}" for words in owner.failures), *owner.said, sep="\n")
            print(*(f"THE MACHINE: {words}" for words in owner.machine), sep="\n")
    return (2 if owner.machine else 1) if owner.failures else 0


if __name__ == "__main__":
    sys.exit(main())
