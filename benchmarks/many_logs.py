"""A candidate judged on a folder of logs: how does the time grow with how many, and how long?

    python benchmarks/many_logs.py [--logs 1000] [--seconds 120] [--jobs 2]
    python benchmarks/many_logs.py --figure docs/figures/many_logs.png

What `reflexarc replay FOLDER --policy NEW.onnx --level policy --markdown` does: copies of one drive
at 50 Hz, a candidate that decides nearly every tick otherwise, the whole report. Elapsed time and
processor time of all processes, their start included; per log and per tick of processor time: flat
columns mean that nothing grows faster than the logs. Nothing is asserted. On a machine that does
other work, processor time over processes is what two free cores would take.
"""

import argparse
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))  # the tests' recordings

from reflexarc_logs.judging.judge_logs import judge_logs
from reflexarc_logs.reading.log_paths import log_paths
from support.policies import exported  # found by the line above
from support.recordings import CONTRACT, drive, nominal

RATE_HZ = 50


class Row(NamedTuple):
    """One folder."""

    logs: int
    seconds: int
    taken_s: float
    worked_s: float
    """Of processor time."""


def main() -> None:
    """Record, judge, print."""
    arguments = _arguments()
    head = f"{'logs':>6}{'s each':>8}{'elapsed s':>11}{'processor s':>13}"
    print(head + f"{'ms a log':>10}{'µs a tick':>11}")
    rows = []
    for logs, seconds in _sizes(arguments.logs, arguments.seconds):
        row = _row(logs, seconds, arguments.jobs)
        each_s = row.worked_s / logs
        figures = f"{1e3 * each_s:>10.1f}{1e6 * each_s / (seconds * RATE_HZ):>11.2f}"
        print(
            f"{logs:>6}{seconds:>8}{row.taken_s:>11.2f}{row.worked_s:>13.2f}{figures}", flush=True
        )
        rows.append(row)
    if arguments.figure is not None:
        _draw(rows, arguments)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--logs", type=int, default=1000)
    parser.add_argument("--seconds", type=int, default=120)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--figure", type=Path, help="draw the growth into this file")
    return parser.parse_args()


def _sizes(logs: int, seconds: int) -> Iterator[tuple[int, int]]:
    """How many logs, and how long: one grows, and then the other."""
    for share in (16, 4, 2, 1):
        yield max(1, logs // share), seconds
    for times in (4, 16):
        yield max(1, logs // 16), times * seconds


def _row(logs: int, seconds: int, jobs: int) -> Row:
    with tempfile.TemporaryDirectory() as name:
        folder, candidate = Path(name) / "logs", Path(name) / "candidate.onnx"
        folder.mkdir()
        candidate.write_bytes(exported(CONTRACT, seed=6))
        first, ticks = folder / "0.mcap", seconds * RATE_HZ
        drive(first, exported(CONTRACT, seed=5), nominal(ticks), ticks)
        for k in range(1, logs):
            shutil.copyfile(first, folder / f"{k}.mcap")
        began_s, worked_s = time.perf_counter(), _processor_s()
        found = judge_logs(log_paths([folder]), candidate, jobs=jobs)
        found.markdown()
        row = Row(logs, seconds, time.perf_counter() - began_s, _processor_s() - worked_s)
    if any(log.problem or not log.flips for log in found.logs):
        raise SystemExit("a log was not judged")
    return row


def _processor_s() -> float:
    """Of this process, and of those that it started and that have ended."""
    return sum(os.times()[:4])


def _draw(rows: list[Row], arguments: argparse.Namespace) -> None:
    """Elapsed time over how many logs, and over how long they are."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot

    figure, (by_count, by_length) = pyplot.subplots(1, 2, figsize=(7.2, 2.8), layout="constrained")
    counts = [row for row in rows if row.seconds == arguments.seconds]
    least = min(row.logs for row in rows)
    lengths = [row for row in rows if row.logs == least]
    for axes, some, column in ((by_count, counts, 0), (by_length, lengths, 1)):
        axes.plot([r[column] for r in some], [r.taken_s for r in some], "o--", label="elapsed")
        axes.plot([r[column] for r in some], [r.worked_s for r in some], "o-", label="processor")
    by_count.set(xlabel=f"logs of {arguments.seconds} s", ylabel="s")
    by_length.set(xlabel=f"seconds each, {least} logs")
    by_count.legend()
    for axes in (by_count, by_length):
        axes.set(xlim=(0, None), ylim=(0, None))
        axes.grid(alpha=0.3)
    figure.suptitle(f"A candidate judged on a folder of logs, {arguments.jobs} processes")
    figure.savefig(arguments.figure, dpi=110)


if __name__ == "__main__":
    main()
