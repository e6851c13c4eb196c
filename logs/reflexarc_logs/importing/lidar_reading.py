"""Reads a lidar log in one pass: its lines become encoded messages with new times.

`lidar_import` writes them.
"""

from collections import Counter
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path

import numpy as np

from reflexarc_logs.importing.carmen import Carmen
from reflexarc_logs.importing.coreslam import CoreSlam
from reflexarc_logs.importing.lidar_messages import ODOMETRY_FRAME, WORLD_FRAME, LidarMessages
from reflexarc_logs.importing.scan_line import NO_RETURN, BrokenLineError, LineReader, Sweep
from reflexarc_logs.importing.scan_times import NewTimes
from reflexarc_logs.importing.text_blocks import MAX_LINE_BYTES, text_blocks
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages.topics import ODOMETRY, POSE, SCAN, TRANSFORM

FORMATS: dict[str, Callable[[], LineReader]] = {"carmen": Carmen, "coreslam": CoreSlam}
DEFAULT_RATE_HZ = 10.0
HEAD_BLOCKS = 16
"""A megabyte: so much is looked at before the first line is read."""
MOST_LINES, MOST_BLOCKS = 1_000_000, 4096
"""So many lines, or 256 MiB, without a scan are no lidar log: hours of a robot's odometry."""
RECORDED = "recorded"
"""Given in place of a rate: keep the file's own times."""

EncodedMessage = tuple[str, int, bytes]
"""The name of a topic, the new time in nanoseconds, the payload."""


@dataclass
class ImportReport:
    """What an import found in a file, and what it wrote."""

    source: str
    format: str
    log: str
    robot: str
    rate_hz: float
    """0 where the file's own times were kept."""
    lines: int = 0
    scans: int = 0
    seconds: float = 0.0
    """From the first scan to the last one, by their new times."""
    poses: int = 0
    odometry: int = 0
    beams: int = 0
    no_return: int = 0
    unknown: dict[str, int] = field(default_factory=dict)
    """How many beams have no known distance, by kind."""
    broken_lines: dict[str, int] = field(default_factory=dict)
    """How many lines were left out, by kind."""
    first_broken_line: int | None = None
    """Its number, from 1."""
    passed_over: dict[str, int] = field(default_factory=dict)
    """How many well-formed lines carry no scan, by keyword."""
    times_left_out: int = 0
    """How many scans have a time that no message can hold."""
    notes: tuple[str, ...] = ()


def read_lidar(
    path: Path, times: NewTimes, report: ImportReport
) -> Generator[list[EncodedMessage], None, None]:
    """Yield the messages of a file in order, those of some lines at once.

    Args:
        path: a text log, plain or gzip.
        times: gives every scan its new time.
        report: names the format and the robot; the rest is filled in while reading.

    Raises:
        LogError: the file cannot be read or has no scan; its times were asked for and do not grow.
    """
    reading, blocks, head = _Reading(path, times, report), text_blocks(path), list[list[bytes]]()
    for lines in blocks:
        head.append(lines)
        if len(head) == HEAD_BLOCKS:
            break
    reading.foresee([line for lines in head for line in lines])
    for lines in chain(head, blocks):
        yield reading.records(lines)
    reading.conclude()


class _Reading:
    """Reads one file and counts what is in it."""

    def __init__(self, path: Path, times: NewTimes, report: ImportReport) -> None:
        self._path = path
        self._times = times
        self._report = report
        self._format = FORMATS[report.format]()
        self._messages = LidarMessages(report.robot)
        self._broken: Counter[str] = Counter()
        self._unknown = 0
        self._unreadable = 0
        self._first_fault = ""
        self._last_scan = 0
        self._blocks_without_scan = 0

    def foresee(self, lines: list[bytes]) -> None:
        """Show the beginning of the file to the reader of its format."""
        self._format.foresee(lines)

    def records(self, lines: list[bytes]) -> list[EncodedMessage]:
        """The messages of the next lines of the file.

        Raises:
            LogError: there was no scan for so long that none will come.
        """
        sweeps = list(self._sweeps(lines))
        if sweeps:
            self._count([sweep for sweep, _ in sweeps])
        self._keep_patience(bool(sweeps))
        return [record for sweep, number in sweeps for record in self._encoded(sweep, number)]

    def conclude(self) -> None:
        """Complete the report.

        Raises:
            LogError: the file has no scan, or its times were asked for and do not grow.
        """
        self._check()
        self._sum_up()

    def _sweeps(self, lines: list[bytes]) -> Iterator[tuple[Sweep, int]]:
        """Every scan with the number of its line."""
        first = self._report.lines + 1
        self._report.lines += len(lines)
        for number, line in enumerate(lines, first):
            try:
                sweep = self._format.sweep(line)
            except BrokenLineError as error:
                self._note_broken(number, line, str(error))
                continue
            if sweep is not None:
                yield sweep, number

    def _keep_patience(self, has_scans: bool) -> None:
        if has_scans:
            self._last_scan, self._blocks_without_scan = self._report.lines, 0
            return
        self._blocks_without_scan += 1
        lines = self._report.lines - self._last_scan
        if lines > MOST_LINES or self._blocks_without_scan > MOST_BLOCKS:
            raise LogError(
                f"{self._path}: expected a {self._report.format} log ({self._format.expects}), "
                f"found no scan in {lines} lines from line {self._last_scan + 1} on"
                f"{self._first_fault}"
            )

    def _count(self, sweeps: list[Sweep]) -> None:
        report, ranges_m = self._report, np.concatenate([sweep.ranges_m for sweep in sweeps])
        report.scans += len(sweeps)
        report.beams += len(ranges_m)
        report.no_return += int(np.count_nonzero(ranges_m == NO_RETURN))
        self._unknown += int(np.count_nonzero(np.isnan(ranges_m)))
        self._unreadable += sum(sweep.unreadable for sweep in sweeps)
        report.times_left_out += sum(sweep.time_ns is None for sweep in sweeps)
        report.poses += sum(sweep.pose is not None for sweep in sweeps)
        report.odometry += sum(sweep.odometry is not None for sweep in sweeps)

    def _encoded(self, sweep: Sweep, line: int) -> list[EncodedMessage]:
        """The messages of one scan."""
        messages, time_ns = self._messages, self._times.of(sweep.time_ns, line)
        self._report.seconds = time_ns / 1e9
        records = [(SCAN.name, time_ns, messages.scan(sweep))]
        if sweep.pose is not None:
            records.append((POSE.name, time_ns, messages.pose(sweep.pose, WORLD_FRAME)))
            records.append((TRANSFORM.name, time_ns, messages.transform(sweep.pose)))
        if sweep.odometry is not None:
            odometry = messages.pose(sweep.odometry, ODOMETRY_FRAME)
            records.append((ODOMETRY.name, time_ns, odometry))
        return records

    def _note_broken(self, number: int, line: bytes, kind: str) -> None:
        if len(line) == MAX_LINE_BYTES:
            kind = "longer than 1 MiB"
        elif not line.endswith(b"\n"):
            kind = "cut off at the end of the file"
        self._broken[kind] += 1
        self._first_fault = self._first_fault or f"; line {number}: {kind}"
        self._report.first_broken_line = self._report.first_broken_line or number

    def _check(self) -> None:
        """Check that the file had scans with distances, and usable times."""
        report = self._report
        if not report.scans:
            raise LogError(
                f"{self._path}: expected a {report.format} log ({self._format.expects}), "
                f"found no scan in {report.lines} lines{self._first_fault}"
            )
        if self._unknown == report.beams:
            raise LogError(
                f"{self._path}: no beam of its {report.scans} scans has a distance "
                f"({_counts(self._kinds())}); is it a {report.format} log?"
            )
        if fault := self._times.fault():
            raise LogError(
                f"{self._path}: --rate {RECORDED} needs times that grow; {fault}; "
                f"spread the scans evenly instead: --rate {DEFAULT_RATE_HZ:g}"
            )

    def _sum_up(self) -> None:
        report, log_format = self._report, self._format
        report.unknown = self._kinds()
        report.broken_lines = dict(self._broken)
        report.passed_over = log_format.passed_over()
        report.notes = log_format.notes()
        if report.no_return + self._unknown == report.beams:
            report.notes = (_without_return(report), *report.notes)

    def _kinds(self) -> dict[str, int]:
        """How many beams have no known distance, by kind."""
        blind = self._format.blind_beams * self._report.scans
        kinds = {
            self._format.no_distance: self._unknown - self._unreadable - blind,
            "no number": self._unreadable,
            "blind": blind,
        }
        return {kind: count for kind, count in kinds.items() if count}


def _counts(kinds: dict[str, int]) -> str:
    return ", ".join(f"{count} {kind}" for kind, count in kinds.items())


def _without_return(report: ImportReport) -> str:
    known = "" if report.no_return == report.beams else "whose distance is known "
    return (
        f"all {report.no_return:,} beams {known}are without return: is the file in metres, as the "
        "format is, or in centimetres or millimetres?"
    )
