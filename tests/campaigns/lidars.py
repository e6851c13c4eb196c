"""Lidars as they are sold, at their own pace: how much of the time does a robot drive by them?

    python tests/campaigns/lidars.py [--hz 5.5 7.5 10 20 40] [--age 0.1 0.4] [--bridge-flag FLAG]

Each row starts a robot that speaks ROS 2 with a lidar of that rate, `reflexarc ros2` and
`reflexarc run --input scan --record`, and lets the lidar jitter by a tenth of its period, lose one
scan in ten, send out of a queue of 2 s, empty it at once, and die. Shown are the shares of ticks
that drive, and the way from the lidar's last scan to standstill, by the twists that the robot was
told, beside the longest that it may be: speed × (oldest input + a period of the bridge) +
speed² / (2 × deceleration). Nothing is asserted.
"""

import argparse
import signal
import sys
import tempfile
import time
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))  # the tests' support package

import zenoh

from reflexarc_logs.reading.reader import Log, read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.decision import Verdict
from support.policies import exported
from support.processes import finished, said_line, started
from support.ros2_base import Base, rolled
from support.ros2_drives import FAST_ENOUGH
from support.ros2_robot import Robot, free_port, router
from support.slow_lidar import PHASES, Phase, play, script

BRAKING_MPS2 = 2.0
BRIDGE_PERIOD_S = 0.02
AFTER_DEATH_S = 1.5
SAID_AT_NS = round(PHASES[1].end_s * 1e9)
LOOKED_AT = [phase for phase in PHASES if phase.look_s[1]]


@dataclass(frozen=True)
class Row:
    """One lidar with one policy."""

    rate_hz: float
    age_s: float
    shares: dict[str, float]
    rolled_m: float
    bound_m: float
    replays: bool
    said: str
    """Of the sensor, on the status topic."""

    @property
    def line(self) -> str:
        """As a line of the table."""
        shares = " | ".join(f"{share:.0%}" for share in self.shares.values())
        way = f"{self.rolled_m:.2f} | {self.bound_m:.2f}"
        replays = "yes" if self.replays else "NO"
        return f"| {self.rate_hz:g} | {self.age_s:g} | {shares} | {way} | {replays} | {self.said} |"


class Said:
    """What the runtime's status says of its sensor, and when."""

    def __init__(self) -> None:
        self._said: list[tuple[int, str]] = []

    def hear(self, sample: zenoh.Sample) -> None:
        """Take one status."""
        status = pb.Status.FromString(sample.payload.to_bytes())
        if status.node == "runtime":
            self._said.append((time.monotonic_ns(), status.sensor))

    def at(self, at_ns: int) -> str:
        """The last words before a time, without the advice."""
        words = [sensor for when_ns, sensor in self._said if when_ns <= at_ns]
        return words[-1].partition(". ")[0] if words else ""


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--hz", type=float, nargs="+", default=[5.5, 7.5, 10.0, 20.0, 40.0])
    parser.add_argument("--age", type=float, nargs="+", default=[0.1, 0.4])
    parser.add_argument("--bridge-flag", action="append", default=[], help="as --flag=value")
    arguments = parser.parse_args()
    names = " | ".join(phase.name for phase in LOOKED_AT)
    print(f"| Hz | oldest input, s | {names} | rolled, m | at most, m | replays | sensor |")
    print("|---" * (len(LOOKED_AT) + 6) + "|")
    for age_s in arguments.age:
        for rate_hz in arguments.hz:
            with tempfile.TemporaryDirectory() as folder:
                row = measured(rate_hz, age_s, Path(folder), arguments.bridge_flag)
            print(row.line, flush=True)


def measured(rate_hz: float, age_s: float, folder: Path, flags: list[str]) -> Row:
    """One row."""
    policy, log, port = folder / "policy.onnx", folder / "drive.mcap", free_port()
    contract = PolicyContract(max_input_age_s=age_s)
    policy.write_bytes(exported(contract, seed=5))
    with ExitStack() as stack:
        session = stack.enter_context(router(port))
        body = Robot(session, "scan", "cmd_vel", stamped=False)
        session.declare_subscriber("cmd_vel", body.hear)
        said = Said()
        session.declare_subscriber("robot0/status", said.hear)
        words = ("ros2", "--json", "--port", port, "--auto-arm", *FAST_ENOUGH, *flags)
        bridge = stack.enter_context(started(*words, cwd=folder))
        said_line(bridge, "cmd_vel")
        words = ("run", policy, "--input", "scan", "--no-guard", "--record", log, "--json")
        run = stack.enter_context(started(*words, "--port", port, cwd=folder))
        said_line(run, "watchdog")
        begin_ns, death_ns = play(session, "scan", script(rate_hz))
        time.sleep(AFTER_DEATH_S)
        finished(run, signal.SIGINT)
        finished(bridge, signal.SIGINT)
    until_ns = death_ns + round(AFTER_DEATH_S * 1e9)
    read = read_log(log)
    fastest_mps = max(action.linear_mps for action in contract.actions)
    bound_m = fastest_mps * (age_s + BRIDGE_PERIOD_S) + fastest_mps**2 / (2.0 * BRAKING_MPS2)
    return Row(
        rate_hz,
        age_s,
        {phase.name: share(read, phase, begin_ns) for phase in LOOKED_AT},
        rolled(Base(BRAKING_MPS2), body.told, death_ns, until_ns).distance_m,
        bound_m,
        replay(log).exit_status == 0,
        said.at(begin_ns + SAID_AT_NS),
    )


def share(log: Log, phase: Phase, begin_ns: int) -> float:
    """Of the ticks of a phase, those that drive."""
    first_ns, end_ns = (begin_ns + round(at_s * 1e9) for at_s in phase.look_s)
    verdicts = [
        tick.decision.verdict for tick in log.ticks() if first_ns <= tick.decision.now_ns < end_ns
    ]
    return verdicts.count(Verdict.OK.value) / max(1, len(verdicts))


if __name__ == "__main__":
    main()
