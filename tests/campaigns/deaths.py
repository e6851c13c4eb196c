"""A service that is killed and hung at random moments: does it run again, disarmed?

    python tests/campaigns/deaths.py [--deaths 20] [--seed 0] [--keep FOLDER] [--json]

The unit that `reflexarc service` writes is followed by a supervisor of the tests, as no systemd
runs in most containers. A simulated body of --arm-each-runtime drives under one runtime after
another. Each death: SIGKILL, SIGSEGV, SIGABRT, or a hang (SIGSTOP) that nobody continues but the
manager. After each the runtime must run again, and the body stand until it is armed. At the end
everything that was recorded must replay.

Measured: from the death to the first command of the next runtime (`again`), of a hang from its
beginning; and from the end of the process (`started`). Exit status 1: a body that was armed by a
restart, a runtime that did not come back within a minute, a process left over, a log that does not
replay, or 99 % that take longer than 2 s from the end of the process.
"""

import argparse
import json
import os
import random
import signal
import sys
import tempfile
import time
from dataclasses import asdict, dataclass, field
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))  # the tests' support package

import numpy as np

from reflexarc.commands.service.service import ServiceCommand
from reflexarc_logs.container.frames import MAGIC
from reflexarc_logs.reading.log_paths import log_paths
from reflexarc_logs.reading.recover import recover
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.bus import Bus, Publisher
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import ReflexarcError
from reflexarc_runtime.messages.topics import ARM, LEASE
from reflexarc_runtime.messages.wire import Message
from support.fault_runs import free_ports
from support.policies import exported
from support.processes import started
from support.supervisor import Supervisor

PATIENCE_S = 60.0
MOST_S = 2.0
HANG = signal.SIGSTOP
WAYS = (signal.SIGKILL, signal.SIGSEGV, signal.SIGABRT, HANG)
SETTINGS = 'policy = "policy.onnx"\nport = {port}\nrecord = "logs"\nrotate-s = 600\n'


@dataclass
class Witness:
    """What the body says: whom it obeys, and whether it is armed."""

    holder: bytes = b""
    armed: bool = False
    state: str = ""
    holders: list[tuple[float, bytes, bool]] = field(default_factory=list)
    """When each holder was seen first, and whether the body was armed then."""

    def hear(self, message: Message) -> None:
        lease = pb.Lease.FromString(message.payload)
        if lease.holder and lease.holder != self.holder:
            self.holders.append((message.received_ns * 1e-9, lease.holder, lease.armed))
        self.holder = lease.holder or self.holder
        self.armed, self.state = lease.armed, lease.state


@dataclass
class Death:
    """One death, and how the service came back."""

    number: int
    way: str
    after_s: float
    again_s: float = 0.0
    started_s: float = 0.0
    failures: list[str] = field(default_factory=list)


def wait_until(holds: object, what: str, service: Supervisor) -> None:
    """Wait; raises `TimeoutError` with what was waited for."""
    end_s = time.monotonic() + PATIENCE_S
    while not holds():  # type: ignore[operator]
        if time.monotonic() > end_s or service.gave_up:
            raise TimeoutError(f"waited in vain for {what}: {service.lives[-1]}")
        time.sleep(0.002)


def arm(publisher: Publisher, witness: Witness, service: Supervisor) -> None:
    """Say it until the body has done it."""

    def driving() -> bool:
        publisher.put(pb.Arm(reason="campaign").SerializeToString(), time.monotonic_ns())
        time.sleep(0.05)
        return witness.armed and witness.state == "driving"

    wait_until(driving, "a body that drives", service)


def die(death: Death, witness: Witness, service: Supervisor) -> None:
    """Let the runtime die, and wait until the next one holds the body."""
    time.sleep(death.after_s)
    life, seen = service.lives[-1], len(witness.holders)
    struck_s = time.monotonic()
    os.kill(life.process.pid, signal.Signals[death.way])
    wait_until(lambda: len(witness.holders) > seen, "another runtime that holds it", service)
    heard_s, _, armed = witness.holders[seen]
    death.again_s = heard_s - struck_s
    death.started_s = heard_s - (life.ended_s or struck_s)
    if armed:
        death.failures.append("the body was armed for a runtime that nobody armed it for")


def run(deaths: int, seed: int, folder: Path) -> list[Death]:
    """All deaths, one after another."""
    (port,) = free_ports(1)
    (folder / "policy.onnx").write_bytes(exported(PolicyContract()))
    config = folder / "robot.toml"
    config.write_text(SETTINGS.format(port=port))
    unit = ServiceCommand("show", config)._unit().text()
    rng, done, witness = random.Random(seed), [], Witness()
    words = ("sim", "--port", port, "--arm-each-runtime", "--policy", folder / "policy.onnx")
    with started(*words, cwd=folder), Supervisor(unit, folder) as service:
        bus = Bus(BusConfig(port=port), time.monotonic_ns)
        with bus:
            bus.subscribe([LEASE], witness.hear)
            publisher = bus.publisher(ARM)
            for number in range(deaths):
                death = Death(number, rng.choice(WAYS).name, rng.uniform(0.0, 1.5))
                done.append(death)
                try:
                    arm(publisher, witness, service)
                    die(death, witness, service)
                except TimeoutError as error:
                    death.failures.append(str(error))
                    break
                print(f"{death.number + 1}/{deaths} {death.way} {death.again_s:.2f} s", end="\r")
    done[-1].failures += leftovers(service)
    return done


def leftovers(service: Supervisor) -> list[str]:
    """Processes of the service that still are, whoever they are."""
    groups = [life.process.pid for life in service.lives]
    alive = [group for group in groups if _is_alive(group)]
    return [f"left over: process group {group}" for group in alive]


def _is_alive(group: int) -> bool:
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return False
    return True


def judge_logs(folder: Path) -> tuple[int, int, list[str]]:
    """How many logs there are, in how many not even the head was whole, and which do not replay."""
    unborn, bad = 0, []
    for partial in folder.glob("*.partial"):
        try:
            recover(partial, partial.with_suffix(""))
        except ReflexarcError as error:
            unborn += 1
            if partial.read_bytes()[: len(MAGIC)] == MAGIC and partial.stat().st_size > 1 << 16:
                bad.append(f"{partial.name}: {error}")
    paths = log_paths([folder])
    for path in paths:
        try:
            if replay(path).exit_status:
                bad.append(f"{path.name}: differs")
        except ReflexarcError as error:
            bad.append(f"{path.name}: {error}")
    return len(paths), unborn, bad


def main() -> int:
    """Run the campaign; print its table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--deaths", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=Path)
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        folder = given.keep or Path(place)
        folder.mkdir(parents=True, exist_ok=True)
        deaths = run(given.deaths, given.seed, folder)
        logs, unborn, bad = judge_logs(folder / "logs")
    failures = [f"{death.number}: {one}" for death in deaths for one in death.failures] + bad
    if given.json:
        print(json.dumps({"deaths": [asdict(death) for death in deaths], "failures": failures}))
    slow = _print_table(deaths, logs, unborn)
    print("\n".join(failures))
    return int(bool(failures) or slow)


def _print_table(deaths: list[Death], logs: int, unborn: int) -> bool:
    print("| way | deaths | again, s: p50, p99, max | started, s: p50, p99, max |")
    print("|---|---|---|---|")
    for way in (*(each.name for each in WAYS), "all"):
        some = [death for death in deaths if way in (death.way, "all")]
        if some:
            again, began = ([getattr(d, name) for d in some] for name in ("again_s", "started_s"))
            print(f"| {way} | {len(some)} | {_shown(again)} | {_shown(began)} |")
    print(f"logs {logs}, without a head {unborn}")
    return bool(np.percentile([death.started_s for death in deaths], 99) > MOST_S)


def _shown(seconds: list[float]) -> str:
    return ", ".join(f"{value:.2f}" for value in np.percentile(seconds, [50, 99, 100]))


if __name__ == "__main__":
    sys.exit(main())
