"""A service that is killed and hung at random moments: does it run again, disarmed?

    python tests/campaigns/deaths [--deaths 1000] [--parallel 2] [--seed 1] [--systemd] [--json]

The unit that `reflexarc service` writes is followed by a supervisor of the tests, as no systemd
runs in most containers; with --systemd by a real one, which is booted in namespaces of its own and
needs root: there the unit's limits and its made-up user hold as well. A simulated body of
--arm-each-runtime lives on and drives under one runtime after another. Ways to die: `kinds.py`; one
of them strikes while the runtime starts. After
each death another runtime must hold the body, which stands where it stood until it is armed; no
process is left over, in whatever state. At the end the service is asked to stop: status 0, its log
finished; and everything that was recorded must replay, at both levels.

Measured: from the blow to the next runtime that the body obeys (`again`); from the blow to the end
of the process (`ended`); and from that to the next first tick (`started`). Exit status 1: anything
of the above, or `again` over 2 s at the 99th percentile of the kills, over 2 s and the watchdog's
patience at that of the hangs.
"""

import argparse
import json
import os
import sys
import tempfile
import threading
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))  # the tests' packages

import numpy as np

from campaigns.deaths.booted import BootedSystemd
from campaigns.deaths.kinds import WAYS, Death
from campaigns.deaths.replayed import Replayed, replayed
from campaigns.deaths.robot import Robot
from campaigns.deaths.services import followed_service, systemd_service
from support.bytecode import keep_bytecode
from support.fault_runs import free_ports

MOST_S = 2.0
MEASURED = ("again_s", "ended_s", "started_s")


def main() -> int:
    """Run the campaign; print its table."""
    given = _arguments()
    with tempfile.TemporaryDirectory() as place:
        keep_bytecode(Path(place) / "bytecode")
        folder = (given.keep or Path(place)).absolute()
        with ExitStack() as booted:
            robots = [
                _robot(folder / f"robot{number}", port, number, given, booted)
                for number, port in enumerate(free_ports(given.parallel))
            ]
            _run(robots, given.deaths)
        logs = [replayed(robot.folder / "logs") for robot in robots]
    deaths = [death for robot in robots for death in robot.deaths]
    failures = [f"{death.number}, {death.way}: {one}" for death in deaths for one in death.failures]
    failures += [one for each in logs for one in each.bad]
    unprovoked = [one for robot in robots for one in robot.unprovoked]
    if given.json:
        said = {"deaths": [asdict(death) for death in deaths], "logs": [asdict(x) for x in logs]}
        print(json.dumps({**said, "failures": failures, "unprovoked": unprovoked}))
    else:
        _print(deaths, logs, failures, unprovoked)
    slow = np.percentile([death.again_s for death in deaths], 99) > MOST_S
    return int(bool(failures) or bool(slow) or len(deaths) < given.deaths)


def _robot(
    folder: Path, port: int, number: int, given: argparse.Namespace, booted: ExitStack
) -> Robot:
    if given.systemd:
        system = booted.enter_context(BootedSystemd(folder / "systemd"))
        service = systemd_service(system, folder, port, given.keep_mb)
    else:
        service = followed_service(folder, port, given.keep_mb)
    return Robot(folder, port, given.seed + number, service)


def _run(robots: Sequence[Robot], deaths: int) -> None:
    done = []

    def told(death: Death) -> None:
        done.append(death)
        if sys.stderr.isatty():
            print(f"{len(done)}/{deaths} {death.again_s:.2f} s", end="\r", file=sys.stderr)

    shares = [len(range(number, deaths, len(robots))) for number in range(len(robots))]
    threads = [
        threading.Thread(target=robot.die, args=(share, told))
        for robot, share in zip(robots, shares, strict=True)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def _print(
    deaths: Sequence[Death],
    logs: Sequence[Replayed],
    failures: Sequence[str],
    unprovoked: Sequence[str],
) -> None:
    print("| way | deaths | again, s: p50, p99, max | ended | started | how it ended |")
    print("|---|---|---|---|---|---|")
    for way in (*(each.name for each in WAYS), "all"):
        some = [death for death in deaths if way in (death.way, "all")]
        if some:
            shown = (_shown([getattr(death, name) for death in some]) for name in MEASURED)
            ends = sorted({f"{death.status} {death.cause}".strip() for death in some})
            told = "" if way == "all" else ", ".join(ends)
            print(f"| {way} | {len(some)} | {' | '.join(shown)} | {told} |")
    finished, recovered, empty = (
        sum(getattr(each, name) for each in logs) for name in ("finished", "recovered", "empty")
    )
    print(f"logs: {finished} finished, {recovered} recovered, {empty} of them without a tick")
    print(f"load {os.getloadavg()[0]:.1f}; unprovoked: {'; '.join(unprovoked) or 'none'}")
    print("\n".join(failures) or "no failures")


def _shown(seconds: Sequence[float]) -> str:
    return ", ".join(f"{value:.2f}" for value in np.percentile(seconds, [50, 99, 100]))


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--deaths", type=int, default=1000)
    parser.add_argument("--parallel", type=int, default=2, help="robots at once")
    parser.add_argument("--systemd", action="store_true", help="under a real one; needs root")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep-mb", type=float, default=2000.0, help="of each robot's logs")
    parser.add_argument("--keep", type=Path, help="keep the logs here")
    parser.add_argument("--json", action="store_true")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
