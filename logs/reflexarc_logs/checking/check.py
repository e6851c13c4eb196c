"""Checks one log, ours or anybody's: bytes, completeness, gaps, clocks, contract, replay.

One pass checks the frame, one the attachments, one reads every message; a log of ours is then
replayed, as far as its bytes are sound.
"""

from dataclasses import dataclass, field
from pathlib import Path

from foxglove_schemas_protobuf.Log_pb2 import Log as FoxgloveLog
from google.protobuf.message import DecodeError

from reflexarc_logs.checking.byte_checks import (
    attachment_findings,
    frame_findings,
    index_findings,
)
from reflexarc_logs.checking.check_report import LogCheck, SensorCheck
from reflexarc_logs.checking.course_findings import clock_findings, gap_findings
from reflexarc_logs.checking.findings import LogFinding, error, warning
from reflexarc_logs.checking.run_checks import (
    contract_findings,
    loss_findings,
    replay_findings,
    should_hold_all,
)
from reflexarc_logs.checking.stream_course import StreamCourse
from reflexarc_logs.checking.tick_course import TickCourse
from reflexarc_logs.container.first_look import Survey, look
from reflexarc_logs.container.writing import POLICY_ATTACHMENT
from reflexarc_logs.diffing.message_file import MessageFile, StreamMessage
from reflexarc_logs.reading.reader import Log, open_log
from reflexarc_logs.reading.runtime_status import named_pace, runtime_status
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages.topics import LOG, RECORDER_NODE, STATUS, TICK

_MOST_NOTES = 3


def check(path: Path) -> LogCheck:
    """Check a log.

    Args:
        path: the file; what is wrong with it stands in the result, also that it cannot be read.
    """
    try:
        found = look(path)
    except LogError as refusal:
        return LogCheck(str(path), refusal=_without_path(refusal, path))
    if not found.is_mcap or found.refusal:
        return LogCheck(str(path), refusal=found.damage)
    return _Check(found).done()


@dataclass
class _Courses:
    """What one reading of a log says of its streams."""

    streams: dict[str, StreamCourse] = field(default_factory=dict)
    whole: StreamCourse = field(default_factory=lambda: StreamCourse(""))
    ticks: dict[str, TickCourse] = field(default_factory=dict)
    paces: dict[str, str] = field(default_factory=dict)
    """What the runtime of each robot says of its pace: `input`, if it ever does."""
    notes: list[str] = field(default_factory=list)
    """What a recorder wrote down of itself."""

    def add(self, message: StreamMessage) -> None:
        stream, sequence, log_ns, sent_ns, payload = message
        course = self.streams.get(stream.topic)
        if course is None:
            course = self.streams[stream.topic] = StreamCourse(stream.topic)
        course.add(sequence, log_ns, sent_ns)
        self.whole.add(0, log_ns, log_ns)
        if stream.type_name == TICK.schema:
            self.ticks.setdefault(stream.topic, TickCourse()).add(payload)
        elif stream.type_name == STATUS.schema:
            self._note_pace(_robot_of(stream.topic), payload)
        elif stream.type_name == LOG.schema and len(self.notes) < _MOST_NOTES:
            self._listen(payload)

    def pace_of(self, topic: str) -> str:
        """The pace of the loop whose ticks a topic holds, as its statuses say it."""
        return self.paces.get(_robot_of(topic), "")

    def _note_pace(self, robot: str, payload: bytes) -> None:
        status = runtime_status(payload)
        if status is not None and self.paces.get(robot) != "input":
            self.paces[robot] = named_pace(status) or self.paces.get(robot, "")

    def _listen(self, payload: bytes) -> None:
        try:
            said = FoxgloveLog.FromString(payload)
        except DecodeError:
            return
        if said.name == RECORDER_NODE:
            self.notes.append(said.message[:200])


class _Check:
    """One log while it is checked.

    Args:
        found: the first look at it.
    """

    def __init__(self, found: Survey) -> None:
        self._found, self._path = found, found.path
        self._courses = _Courses()
        self._findings: list[LogFinding] = []
        self._replay = ""

    def done(self) -> LogCheck:
        """Check it, and say what was found."""
        self._findings += frame_findings(self._found)
        self._read()
        log = self._ours()
        self._look_at_streams(log)
        if log is not None:
            self._look_at_run(log)
        return self._result(log)

    def _read(self) -> None:
        try:
            self._findings += attachment_findings(self._path, self._found.intact_size)
            for message in MessageFile(self._path).messages():
                self._courses.add(message)
        except (LogError, OSError) as failure:
            if not self._found.damage:
                self._findings.append(error("bytes", _without_path(failure, self._path)))
        if self._found.complete and not self._findings:
            self._findings += index_findings(self._path, self._courses.whole.count)

    def _ours(self) -> Log | None:
        if not self._found.is_ours:
            return None
        try:
            return open_log(self._found)
        except LogError as failure:
            self._findings.append(error("contract", _without_path(failure, self._path)))
            return None

    def _look_at_streams(self, log: Log | None) -> None:
        courses, streams = self._courses, list(self._courses.streams.values())
        is_whole = log is not None and should_hold_all(log) and self._found.complete
        pace = "" if log is None else log.run.pace
        for topic, ticks in courses.ticks.items():
            whose = f"{topic}: " if len(courses.ticks) > 1 else ""
            for one in ticks.findings(is_whole=is_whole, pace=pace or courses.pace_of(topic)):
                self._findings.append(LogFinding(one.kind, one.severity, whose + one.words))
        if not streams:
            self._findings.append(error("completeness", "it holds no message"))
        self._findings += gap_findings(streams, courses.whole)
        self._findings += clock_findings(streams)

    def _look_at_run(self, log: Log) -> None:
        self._findings += loss_findings(log.metadata)
        for note in self._courses.notes:
            self._findings.append(warning("clocks", f"its recorder said: {note}"))
        self._findings += contract_findings(log)
        if self._courses.ticks and POLICY_ATTACHMENT in log.attachments:
            is_sound = not any(f.kind == "bytes" for f in self._findings) and log.complete
            self._replay, more = replay_findings(log) if is_sound else ("not tried", [])
            self._findings += more

    def _result(self, log: Log | None) -> LogCheck:
        whole = self._courses.whole
        return LogCheck(
            path=str(self._path),
            is_ours=self._found.is_ours,
            bytes=self._found.size,
            messages=whole.count,
            duration_s=(whole.last_ns - whole.first_ns) * 1e-9,
            ticks=sum(ticks.order.ticks for ticks in self._courses.ticks.values()),
            sensor=self._sensor(log),
            replay=self._replay,
            findings=tuple(sorted(self._findings, key=lambda f: f.severity != "error")),
        )

    def _sensor(self, log: Log | None) -> SensorCheck | None:
        """Of ours the stream that the loop decides on; else the regular one with the worst gap."""
        topic = None if log is None else log.topic(log.run.input)
        chosen = self._courses.streams.get(topic or "") or max(
            (c for c in self._courses.streams.values() if c.period_ns),
            key=lambda c: c.longest_ns / (c.period_ns or 1.0),
            default=None,
        )
        if chosen is None:
            return None
        period_ns = chosen.period_ns or 0.0
        return SensorCheck(chosen.topic, period_ns * 1e-9, chosen.longest_ns * 1e-9)


def _without_path(failure: Exception, path: Path) -> str:
    return str(failure).removeprefix(f"{path}: ")


def _robot_of(topic: str) -> str:
    return topic.rpartition("/")[0]
