"""Imports a bag of ROS 2 as a log: scans, odometry, transforms and pictures in Foxglove's terms.

`log_time` and `publish_time` are when the bag's recorder took a message, by its wall clock. The
stamps of the headers, on the robot's clock, stay in the messages. A message that cannot be used is
counted by its reason and left out, never mended.
"""

import json
import platform
import uuid
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from reflexarc_logs.bags.bag_file import BagFile, BagMessage
from reflexarc_logs.bags.bag_streams import STATIC, BagStream, BagWishes, streams_of
from reflexarc_logs.container.packing.compression import QUICK_LEVEL, FixedCompressor
from reflexarc_logs.container.run_info import RUN, RunInfo, installed_versions
from reflexarc_logs.container.writing import CONFIG_ATTACHMENT, LogWriter
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages.topics import SCAN
from reflexarc_runtime.ros2.cdr import UnusableMessageError
from reflexarc_runtime.ros2.frames import decode_transforms
from reflexarc_runtime.ros2.mounts import Mounts
from reflexarc_runtime.ros2.ros_types import TF_MESSAGE

CHUNK_BYTES = 1 << 20
UNFINISHED = ".importing"
SECOND_NS = 1_000_000_000


@dataclass
class BagImport:
    """What an import found in a bag, and what it wrote."""

    source: str
    log: str
    robot: str
    seconds: float = 0.0
    """From the first message that was taken in to the last one."""
    messages: dict[str, int] = field(default_factory=dict)
    """How many messages each topic of the log has."""
    became: dict[str, str] = field(default_factory=dict)
    """Topic of the bag → topic of the log."""
    unusable: dict[str, int] = field(default_factory=dict)
    """How many messages were left out, by topic and reason."""
    left_out: dict[str, int] = field(default_factory=dict)
    """Topics of the bag that no log of ours takes in, and how many messages they have."""


def import_bag(path: Path | str, out: Path | str, wishes: BagWishes | None = None) -> BagImport:
    """Import one bag.

    Args:
        path: its folder, or one of its files.
        out: the log to be; it must not exist. After an error it does not.
        wishes: which topics become the robot's scan and odometry.

    Raises:
        LogError: the bag cannot be read or has nothing to take in; `out` exists or cannot be
            written.
        UsageError: several topics could be the scan.
    """
    wishes = wishes or BagWishes()
    with BagFile(Path(path)) as bag:
        work = _Import(bag, BagImport(str(path), str(Path(out)), wishes.robot), wishes)
        file = LogWriter(Path(out), UNFINISHED, CHUNK_BYTES, FixedCompressor(QUICK_LEVEL))
        try:
            work.write(file)
            file.finish()
        except OSError as error:
            file.discard()
            raise LogError(f"{out}: cannot be written: {error.strerror}; nothing is left") from None
        except BaseException:
            file.discard()
            raise
        return work.report


class _Import:
    """One bag on its way into a log."""

    def __init__(self, bag: BagFile, report: BagImport, wishes: BagWishes) -> None:
        self.report = report
        self._bag = bag
        self._wishes = wishes
        self._mounts = Mounts(wishes.base)
        self._now_ns = 0
        streams = streams_of(bag.topics, wishes, lambda frame: self._mounts.of(frame, self._now_ns))
        self._streams = {stream.source: stream for stream in streams}
        self._unusable: Counter[str] = Counter()
        self._written: Counter[str] = Counter()
        self._span_ns: list[int] = []
        report.became = {stream.source.name: stream.topic for stream in streams}
        report.left_out = {t.name: t.messages for t in bag.topics if t not in self._streams}

    def write(self, file: LogWriter) -> None:
        """Read the bag twice, first for its fixed frames, and write the log.

        Raises:
            LogError: nothing of it can be taken in.
        """
        self._learn_frames()
        self._begin(file)
        for message in self._bag.messages(self._streams):
            self._take(file, self._streams[message.topic], message)
        self.report.messages = dict(sorted(self._written.items()))
        self.report.unusable = dict(self._unusable.most_common())
        if not self._written:
            raise LogError(f"{self._bag.path}: {self._why_nothing()}")
        first_ns, last_ns = self._span_ns
        self.report.seconds = (last_ns - first_ns) / SECOND_NS

    def _learn_frames(self) -> None:
        fixed = f"/{STATIC}", TF_MESSAGE.name
        static = [topic for topic in self._bag.topics if topic[:2] == fixed]
        for message in self._bag.messages(static):
            try:
                for transform in decode_transforms(message.payload):
                    self._mounts.learn(transform)
            except UnusableMessageError:
                continue  # counted when the topic itself is taken in

    def _take(self, file: LogWriter, stream: BagStream, message: BagMessage) -> None:
        self._now_ns = time_ns = message.time_ns
        try:
            if time_ns < 0:
                raise UnusableMessageError("a time before 1970")
            payloads = stream.read(message.payload)
        except UnusableMessageError as error:
            self._unusable[f"{stream.source.name}: {error}"] += 1
            return
        channel = file.channel(stream.topic, stream.kind)
        for payload in payloads:
            number = self._written[stream.topic]
            file.add(channel, payload, sequence=number, publish_ns=time_ns, log_ns=time_ns)
            self._written[stream.topic] += 1
        self._span_ns = [*self._span_ns[:1], time_ns] if self._span_ns else [time_ns, time_ns]

    def _begin(self, file: LogWriter) -> None:
        run = RunInfo(
            run_id=uuid.uuid4().hex,
            robot=self._wishes.robot,
            input=SCAN.name,
            recorded_by="import",
            host=platform.node(),
            versions=installed_versions(),
        )
        file.describe(RUN, run.to_metadata())
        about = {"format": "ros2bag", "file": self._bag.path.name, "topics": self.report.became}
        config = {"import": {**about, "ros_distro": self._bag.ros_distro}}
        document = json.dumps(config, indent=2, sort_keys=True).encode()
        file.attach(CONFIG_ATTACHMENT, "application/json", document)

    def _why_nothing(self) -> str:
        if self._unusable:
            reason, count = self._unusable.most_common(1)[0]
            return f"no message of it can be used; {count} are: {reason}"
        names = ", ".join(sorted({t.type_name for t in self._bag.topics})) or "nothing"
        return f"expected scans, odometry, transforms or images, found {names}"
