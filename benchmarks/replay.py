"""How fast is replay? Ticks a second at both levels, of a log recorded by the real node.

    python benchmarks/replay.py [--ticks 20000] [--json]

Opening the log (one pass that checks its CRC) is timed apart. Nothing is asserted.
"""

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))  # the tests' recordings

from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.replaying.replay import replay
from support.policies import exported  # found by the line above
from support.recordings import CONTRACT, drive, nominal

REPEATS = 3


def main() -> None:
    """Record, replay, print."""
    arguments = _arguments()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.mcap"
        recording_s = _record(path, arguments.ticks)
        figures = _figures(path, arguments.ticks)
    figures["loop and recorder, ticks a second"] = arguments.ticks / recording_s
    if arguments.json:
        print(json.dumps(figures))
        return
    for name, value in figures.items():
        print(f"{name:<34}{value:>12,.0f}")


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--ticks", type=int, default=20_000)
    parser.add_argument("--json", action="store_true")
    return parser.parse_args()


def _record(path: Path, ticks: int) -> float:
    schedule, policy = nominal(ticks), exported(CONTRACT)
    began_s = time.perf_counter()
    drive(path, policy, schedule, ticks)
    return time.perf_counter() - began_s


def _figures(path: Path, ticks: int) -> dict[str, float]:
    log = read_log(path)
    opening_s = _best(lambda: read_log(path))
    policy_s = _best(lambda: replay(log, level="policy"))
    node_s = _best(lambda: replay(log, level="node"))
    return {
        "ticks in the log": ticks,
        "log, KiB": path.stat().st_size / 1024,
        "open and check, ticks a second": ticks / opening_s,
        "level policy, ticks a second": ticks / policy_s,
        "level node, ticks a second": ticks / node_s,
    }


def _best(action: Callable[[], object]) -> float:
    """The fastest of a few runs: the least disturbed one."""
    times = []
    for _ in range(REPEATS):
        began_s = time.perf_counter()
        action()
        times.append(time.perf_counter() - began_s)
    return min(times)


if __name__ == "__main__":
    main()
