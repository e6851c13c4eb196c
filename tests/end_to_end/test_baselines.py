"""A baseline with a memory as a file: it drives the robot, is recorded, and replays identically."""

from pathlib import Path

import pytest

from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.replaying.replay import replay
from support.processes import finished, reflexarc, said_line, started

TICKS = 30
"""One and a half seconds at 20 Hz."""
LONG = [pytest.param(name, marks=pytest.mark.long) for name in ("rob-nav", "motor-schemas-sum")]


@pytest.mark.long
@pytest.mark.parametrize("name", ["subsumption", *LONG])
def test_a_baseline_drives_and_replays(name: str, port: int, tmp_path: Path) -> None:
    policy, log = tmp_path / "policy.onnx", tmp_path / "log.mcap"
    done = reflexarc("baselines", "export", name, "--rate", 20, "-o", policy)
    assert done.returncode == 0, done.stderr
    words = ("run", policy, "--port", port, "--record", log, "--ticks", TICKS, "--json")
    with started("sim", "--port", port, "--policy", policy) as body:
        said_line(body, "reflexarc sim:")
        with started(*words) as runtime:
            finished(runtime)
    ticks = [tick.decision for tick in read_log(log).ticks()]
    asked = [decision for decision in ticks if decision.q_values]
    assert len(asked) > 10
    assert len({tuple(decision.state) for decision in asked}) > 3  # it remembers
    for backend in ("numpy", "onnxruntime"):
        report = replay(read_log(log), backend=backend)
        assert report.exit_status == 0, report.lines()
