"""Several robots in one process: one world, a runtime for each."""

import signal
from pathlib import Path

from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.messages.topics import POSE
from support.processes import finished, reflexarc, started

STEPS = 40


def test_two_robots_drive_in_one_world_each_with_a_runtime_of_its_own(
    policy: Path, port: int, tmp_path: Path
):
    logs = [tmp_path / f"robot{number}.mcap" for number in range(2)]
    common = ("--lockstep", "--port", port, "--json")
    with (
        started("run", policy, "--robot", "robot0", "--record", logs[0], *common) as first,
        started("run", policy, "--robot", "robot1", "--record", logs[1], *common) as second,
        started("sim", "--world", "crossing", "--robots", 2, "--steps", STEPS, *common) as bodies,
    ):
        journeys = finished(bodies)
        finished(first, signal.SIGINT)
        finished(second, signal.SIGINT)
    assert {name: journey["steps"] for name, journey in journeys.items()} == {
        "robot0": STEPS,
        "robot1": STEPS,
    }
    for log in logs:
        assert replay(log).exit_status == 0
    starts = [next(iter(read_log(log).records(f"/{log.stem}/{POSE.name}"))) for log in logs]
    assert starts[0].payload != starts[1].payload  # same world, places of their own


def test_a_number_of_robots_that_makes_no_sense_is_refused():
    done = reflexarc("sim", "--robots", 0)
    assert done.returncode == 2
    assert done.stderr.strip() == "reflexarc: --robots: expected 1 to 64, got 0"
