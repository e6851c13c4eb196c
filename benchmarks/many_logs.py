"""A folder of logs: how does the time grow with how many there are, and how long they are?

    python benchmarks/many_logs.py [--logs 1000] [--seconds 120] [--jobs 2]

Reports at level `policy` of copies of one drive at 50 Hz, shared among processes. Elapsed time, and
per tick: flat columns mean that nothing grows faster than the logs. Nothing is asserted.
"""

import argparse
import multiprocessing
import shutil
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))  # the tests' recordings

from reflexarc_logs.replaying.replay import replay
from support.policies import exported  # found by the line above
from support.recordings import CONTRACT, drive, nominal

RATE_HZ = 50


def main() -> None:
    """Record, replay, print."""
    arguments = _arguments()
    print(f"{'logs':>6}{'s each':>8}{'elapsed s':>11}{'ms a log':>10}{'µs a tick':>11}")
    for logs, seconds in _sizes(arguments.logs, arguments.seconds):
        taken_s = _taken_s(logs, seconds, arguments.jobs)
        each = taken_s / logs
        row = f"{1e3 * each:>10.1f}{1e6 * each / (seconds * RATE_HZ):>11.2f}"
        print(f"{logs:>6}{seconds:>8}{taken_s:>11.2f}{row}", flush=True)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--logs", type=int, default=1000)
    parser.add_argument("--seconds", type=int, default=120)
    parser.add_argument("--jobs", type=int, default=2)
    return parser.parse_args()


def _sizes(logs: int, seconds: int) -> Iterator[tuple[int, int]]:
    """How many logs, and how long: one grows, and then the other."""
    for share in (16, 4, 1):
        yield max(1, logs // share), seconds
    for times in (4, 16):
        yield max(1, logs // 16), times * seconds


def _taken_s(logs: int, seconds: int, jobs: int) -> float:
    with tempfile.TemporaryDirectory() as folder:
        first = Path(folder) / "0.mcap"
        ticks = seconds * RATE_HZ
        drive(first, exported(CONTRACT), nominal(ticks), ticks)
        paths = [first, *(first.with_name(f"{k}.mcap") for k in range(1, logs))]
        for path in paths[1:]:
            shutil.copyfile(first, path)
        with multiprocessing.get_context("forkserver").Pool(jobs) as pool:
            pool.map(_status, paths[:jobs])  # everything is loaded
            began_s = time.perf_counter()
            statuses = pool.map(_status, paths, chunksize=4)
            taken_s = time.perf_counter() - began_s
    if any(statuses):
        raise SystemExit("a log does not replay")
    return taken_s


def _status(path: Path) -> int:
    return replay(path, level="policy").exit_status


if __name__ == "__main__":
    main()
