"""A lidar log of another system becomes a log of ours, in one pass and in little memory.

`scan`, `pose`, `tf` and `odometry`, as far as the file has them. `log_time` and `publish_time` are
the new times; the file's own time stays in the messages. What is broken is counted, never mended.
"""

import json
import platform
import uuid
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from reflexarc_logs.carmen import Carmen
from reflexarc_logs.coreslam import CoreSlam
from reflexarc_logs.lidar_messages import ODOMETRY_FRAME, WORLD_FRAME, LidarMessages
from reflexarc_logs.log_file import CONFIG_ATTACHMENT, LogFile
from reflexarc_logs.new_times import EvenTimes, NewTimes, RecordedTimes
from reflexarc_logs.run_info import RUN, RunInfo, installed_versions
from reflexarc_logs.sweep import NO_RETURN, BrokenLineError, LineReader, Sweep
from reflexarc_logs.text_file import MAX_LINE_BYTES, text_lines
from reflexarc_runtime.errors import LogError, UsageError
from reflexarc_runtime.messages import SCHEMAS
from reflexarc_runtime.topics import DEFAULT_ROBOT, ODOMETRY, POSE, SCAN, TRANSFORM, Topic

FORMATS: dict[str, Callable[[], LineReader]] = {"carmen": Carmen, "coreslam": CoreSlam}
DEFAULT_RATE_HZ = 10.0
RECORDED = "recorded"
"""In place of a rate: the file's own times."""


@dataclass
class Imported:
    """What was in a file, and what became of it."""

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
    """Beams that say nothing, by kind."""
    broken_lines: dict[str, int] = field(default_factory=dict)
    """Lines that were left out, by kind."""
    first_broken_line: int | None = None
    """Its number, from 1."""
    passed_over: dict[str, int] = field(default_factory=dict)
    """Good lines that carry no scan, by keyword."""
    times_left_out: int = 0
    """Scans whose own time no message can hold."""
    notes: tuple[str, ...] = ()


def import_log(
    path: Path | str,
    out: Path | str,
    kind: str,
    *,
    rate: float | str = DEFAULT_RATE_HZ,
    robot: str = DEFAULT_ROBOT,
) -> Imported:
    """Import one file.

    Args:
        path: a text log, plain or gzip.
        out: the log to be; it must not exist. After an error it does not.
        kind: carmen or coreslam.
        rate: Hz at which the scans are spread, or "recorded" for the file's own times.
        robot: whose topics they become.

    Raises:
        LogError: the file cannot be read, is of another format or has no scan; its times were
            asked for and do not grow; `out` exists or cannot be written.
        UsageError: no such format or rate.
    """
    if kind not in FORMATS:
        raise UsageError(f"expected {' or '.join(FORMATS)}, got {kind!r}")
    times = _times(rate)
    work = _Import(Path(path), LogFile(Path(out)), kind, times, robot)
    try:
        return work.run()
    except OSError as error:
        work.file.discard()
        raise LogError(f"{out}: cannot be written: {error.strerror}; nothing is left") from None
    except BaseException:
        work.file.discard()
        raise


class _Stream:
    """One topic of the new log; its channel is there from the first message on."""

    def __init__(self, file: LogFile, topic: Topic, robot: str) -> None:
        self.messages = 0
        self._file = file
        self._channel: int | None = None
        self._topic = f"/{topic.key(robot)}"
        self._kind = SCHEMAS[topic.schema]

    def add(self, payload: bytes, time_ns: int) -> None:
        if self._channel is None:
            self._channel = self._file.channel(self._topic, self._kind)
        sequence = self.messages
        self.messages += 1
        self._file.add(
            self._channel, payload, sequence=sequence, publish_ns=time_ns, log_ns=time_ns
        )


class _Import:
    """Carries lines of one file into another."""

    def __init__(self, path: Path, file: LogFile, kind: str, times: NewTimes, robot: str) -> None:
        self.file = file
        self._path = path
        self._format = FORMATS[kind]()
        self._times = times
        self._messages = LidarMessages(robot)
        self._said = Imported(str(path), kind, str(file.path), robot, times.rate_hz)
        self._broken: Counter[str] = Counter()
        self._unknown = 0
        self._scans, self._poses, self._transforms, self._odometry = (
            _Stream(file, topic, robot) for topic in (SCAN, POSE, TRANSFORM, ODOMETRY)
        )

    def run(self) -> Imported:
        self._begin()
        number = 0
        for number, line in enumerate(text_lines(self._path), 1):
            try:
                sweep = self._format.sweep(line)
            except BrokenLineError as error:
                self._note_broken(number, line, str(error))
                continue
            if sweep is not None:
                self._take(sweep, number)
        self._said.lines = number
        self._check()
        self.file.finish()
        return self._conclude()

    def _begin(self) -> None:
        said = self._said
        run = RunInfo(
            run_id=uuid.uuid4().hex,
            robot=said.robot,
            input=SCAN.name,
            rate_hz=said.rate_hz,
            recorded_by="import",
            host=platform.node(),
            versions=installed_versions(),
        )
        self.file.describe(RUN, run.to_metadata())
        rate = said.rate_hz or RECORDED
        config = {"import": {"format": said.format, "file": self._path.name, "rate": rate}}
        document = json.dumps(config, indent=2, sort_keys=True).encode()
        self.file.attach(CONFIG_ATTACHMENT, "application/json", document)

    def _take(self, sweep: Sweep, line: int) -> None:
        time_ns = self._times.of(sweep.time_ns, line)
        self._count(sweep, time_ns)
        messages = self._messages
        self._scans.add(messages.scan(sweep), time_ns)
        if sweep.pose is not None:
            self._poses.add(messages.pose(sweep.pose, WORLD_FRAME), time_ns)
            self._transforms.add(messages.transform(sweep.pose), time_ns)
        if sweep.odometry is not None:
            self._odometry.add(messages.pose(sweep.odometry, ODOMETRY_FRAME), time_ns)

    def _count(self, sweep: Sweep, time_ns: int) -> None:
        said, ranges_m = self._said, sweep.ranges_m
        said.seconds = time_ns / 1e9
        said.times_left_out += sweep.time_ns is None
        said.beams += len(ranges_m)
        said.no_return += np.count_nonzero(ranges_m == NO_RETURN)
        self._unknown += np.count_nonzero(np.isnan(ranges_m))

    def _note_broken(self, number: int, line: bytes, kind: str) -> None:
        if len(line) == MAX_LINE_BYTES:
            kind = "longer than 1 MiB"
        elif not line.endswith(b"\n"):
            kind = "cut off at the end of the file"
        self._broken[kind] += 1
        self._said.first_broken_line = self._said.first_broken_line or number

    def _check(self) -> None:
        """Whether all this makes a log."""
        if not self._scans.messages:
            raise LogError(
                f"{self._path}: expected a {self._said.format} log ({self._format.expects}), "
                f"found no scan in {self._said.lines} lines"
            )
        if fault := self._times.fault():
            raise LogError(
                f"{self._path}: --rate {RECORDED} needs times that grow; {fault}; "
                f"spread the scans evenly instead: --rate {DEFAULT_RATE_HZ:g}"
            )

    def _conclude(self) -> Imported:
        said, log_format = self._said, self._format
        said.scans = self._scans.messages
        said.poses, said.odometry = self._poses.messages, self._odometry.messages
        unreadable = log_format.distances.unreadable
        blind = log_format.blind_beams * said.scans
        kinds = {
            log_format.no_distance: self._unknown - unreadable - blind,
            "no number": unreadable,
            "blind": blind,
        }
        said.unknown = {kind: count for kind, count in kinds.items() if count}
        said.broken_lines = dict(self._broken)
        said.passed_over = log_format.passed_over()
        said.notes = log_format.notes()
        return said


def _times(rate: float | str) -> NewTimes:
    if rate == RECORDED:
        return RecordedTimes()
    if isinstance(rate, str):
        raise UsageError(f"--rate: expected {RECORDED} or a number of Hz, got {rate!r}")
    return EvenTimes(rate)
