"""Imports a lidar log of another system as an MCAP log, in one pass and in little memory.

The log has `scan`, `pose`, `tf` and `odometry`, as far as the file has them. `log_time` and
`publish_time` are the new times; the file's own times stay in the messages. Malformed lines are
counted and left out, never corrected.
"""

import json
import platform
import uuid
from collections.abc import Iterable
from contextlib import closing
from pathlib import Path

from reflexarc_logs.container.packing.compression import QUICK_LEVEL, FixedCompressor
from reflexarc_logs.container.run_info import RUN, RunInfo, installed_versions
from reflexarc_logs.container.writing import CONFIG_ATTACHMENT, LogWriter
from reflexarc_logs.importing.lidar_reading import (
    DEFAULT_RATE_HZ,
    FORMATS,
    RECORDED,
    EncodedMessage,
    ImportReport,
    read_lidar,
)
from reflexarc_logs.importing.scan_times import EvenTimes, NewTimes, RecordedTimes
from reflexarc_runtime.errors import LogError, UsageError
from reflexarc_runtime.messages.codec import SCHEMAS
from reflexarc_runtime.messages.topics import DEFAULT_ROBOT, ODOMETRY, POSE, SCAN, TRANSFORM, Topic

CHUNK_BYTES = 1 << 20
"""Larger than a recording's: an import can be repeated, and large chunks compress better."""

__all__ = ["DEFAULT_RATE_HZ", "FORMATS", "RECORDED", "ImportReport", "import_log"]


def import_log(
    path: Path | str,
    out: Path | str,
    kind: str,
    *,
    rate: float | str = DEFAULT_RATE_HZ,
    robot: str = DEFAULT_ROBOT,
) -> ImportReport:
    """Import one file.

    Args:
        path: a text log, plain or gzip.
        out: the log to be; it must not exist. After an error it does not.
        kind: carmen or coreslam.
        rate: Hz at which the scans are spread, or "recorded" for the file's own times.
        robot: name of the robot, the first part of every topic.

    Raises:
        LogError: the file cannot be read, is of another format or has no scan; its times were
            asked for and do not grow; `out` exists or cannot be written.
        UsageError: no such format or rate.
    """
    if kind not in FORMATS:
        raise UsageError(f"expected {' or '.join(FORMATS)}, got {kind!r}")
    times = _times(rate)
    report = ImportReport(str(path), kind, str(Path(out)), robot, times.rate_hz)
    file = LogWriter(Path(out), chunk_bytes=CHUNK_BYTES, compressor=FixedCompressor(QUICK_LEVEL))
    try:
        _begin(file, report)
        with closing(read_lidar(Path(path), times, report)) as batches:
            _write(file, robot, batches)
        file.finish()
    except OSError as error:
        file.discard()
        raise LogError(f"{out}: cannot be written: {error.strerror}; nothing is left") from None
    except BaseException:
        file.discard()
        raise
    return report


class _Stream:
    """One topic of the new log; its channel is there from the first message on."""

    def __init__(self, file: LogWriter, topic: Topic, robot: str) -> None:
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


def _begin(file: LogWriter, report: ImportReport) -> None:
    run = RunInfo(
        run_id=uuid.uuid4().hex,
        robot=report.robot,
        input=SCAN.name,
        rate_hz=report.rate_hz,
        recorded_by="import",
        host=platform.node(),
        versions=installed_versions(),
    )
    file.describe(RUN, run.to_metadata())
    rate = report.rate_hz or RECORDED
    config = {"import": {"format": report.format, "file": Path(report.source).name, "rate": rate}}
    document = json.dumps(config, indent=2, sort_keys=True).encode()
    file.attach(CONFIG_ATTACHMENT, "application/json", document)


def _write(file: LogWriter, robot: str, batches: Iterable[list[EncodedMessage]]) -> None:
    streams = {
        topic.name: _Stream(file, topic, robot) for topic in (SCAN, POSE, TRANSFORM, ODOMETRY)
    }
    for batch in batches:
        for name, time_ns, payload in batch:
            streams[name].add(payload, time_ns)


def _times(rate: float | str) -> NewTimes:
    if rate == RECORDED:
        return RecordedTimes()
    if isinstance(rate, str):
        raise UsageError(f"--rate: expected {RECORDED} or a number of Hz, got {rate!r}")
    return EvenTimes(rate)
