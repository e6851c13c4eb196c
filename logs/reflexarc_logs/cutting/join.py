"""Makes one log of the parts of a recording: what a run's folder means, whole, in one file.

The manifest says which parts there are and in which order; names say nothing. What a part of one
run and another of the next have in common is their folder alone, so every part must be of the run
that the first one names. What is missing between two parts is said, and stays missing: a replay
leaves out what rests on it.
"""

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from mcap.records import Message

from reflexarc_logs.container.copying import MessageCopier
from reflexarc_logs.container.first_look import is_folder
from reflexarc_logs.container.manifest import MANIFEST, ListedPart, read_manifest
from reflexarc_logs.container.writing import ATTACHED_BESIDE, END, LogWriter, media_type_of
from reflexarc_logs.reading.reader import Log, read_log
from reflexarc_logs.recording.part import PART
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages.topics import TICK
from reflexarc_runtime.messages_pb2 import Tick

UNFINISHED = ".joining"
JOINED = "reflexarc.join"
"""Metadata of the whole: of which parts it was made, and what is missing between them."""


@dataclass(frozen=True)
class JoinReport:
    """What was joined."""

    path: Path
    parts: tuple[str, ...]
    messages: int
    ticks: int
    gaps: tuple[str, ...] = ()
    """What is missing, in words."""


def manifest_in(place: Path) -> Path:
    """The manifest that is meant by itself, or by its folder.

    Raises:
        LogError: there is none, or more than one.
    """
    if not is_folder(place):
        if place.name.endswith(MANIFEST):
            return place
        raise LogError(f"{place}: expected a recording's folder or its manifest (*{MANIFEST})")
    found = sorted(place.glob(f"*{MANIFEST}"))
    if not found:
        raise LogError(
            f"{place}: expected a manifest (*{MANIFEST}) of a recording in parts, found none"
        )
    if len(found) > 1:
        names = ", ".join(one.name for one in found[-5:])  # the newest
        raise LogError(f"{place}: expected one recording, found {len(found)}: name one of {names}")
    return found[0]


def join(place: Path, out: Path) -> JoinReport:
    """Write the parts of a recording that are there to one log, in the order of their manifest.

    Args:
        place: the recording's folder, or its manifest.
        out: the log to be; it must not exist.

    Raises:
        LogError: there are no parts, one cannot be read, is of another run, or holds ticks that
            another one holds as well; or `out` cannot be written.
    """
    listed = read_manifest(manifest_in(place))
    parts = _opened(place, listed)
    whole = _Whole(parts, LogWriter(out, UNFINISHED))
    try:
        whole.write(_gaps(listed))
    except OSError as error:
        whole.file.discard()
        raise LogError(f"{out}: cannot be written: {error.strerror}; nothing was joined") from None
    except BaseException:
        whole.file.discard()
        raise
    names = tuple(part.path.name for part in parts)
    return JoinReport(out, names, whole.messages, whole.ticks, tuple(whole.gaps))


def _opened(place: Path, listed: tuple[ListedPart, ...]) -> list[Log]:
    """The parts that are there; each of the same run."""
    there = [part for part in listed if part.path.is_file()]
    if not there:
        raise LogError(f"{place}: expected finished parts, found none")
    parts = [read_log(part.path) for part in there]
    for one, part in zip(there, parts, strict=True):
        _check_belongs(part, parts[0], one.number)
    return parts


def _check_belongs(part: Log, first: Log, number: int) -> None:
    """Refuse what has the name of a part, and is another file."""
    said = part.metadata.get(PART, {}).get("part", str(number))
    if said != str(number):
        raise LogError(f"{part.path}: expected part {number} by its manifest, it is part {said}")
    if part.run != first.run:
        raise LogError(
            f"{part.path}: expected a part of the run {first.run.run_id[:12]}, as "
            f"{first.path.name} is, got one of {part.run.run_id[:12]}, or recorded otherwise"
        )
    if part.policy != first.policy:
        raise LogError(
            f"{part.path}: expected the policy of {first.path.name}, another one is attached"
        )


def _gaps(listed: tuple[ListedPart, ...]) -> Iterator[str]:
    """Which parts are not there. A number that is not listed had a name that was taken."""
    for part in listed:
        if not part.path.is_file():
            because = f": {part.why}" if part.state in ("removed", "failed") and part.why else ""
            state = {"removed": "removed", "failed": "failed"}.get(part.state, "not there")
            yield f"part {part.number}, {part.path.name}, {state}{because}"


@dataclass
class _Whole:
    """The whole while it is written."""

    parts: list[Log]
    file: LogWriter
    messages: int = 0
    ticks: int = 0
    gaps: list[str] = field(default_factory=list)
    _last: int | None = None
    """The number of the newest tick."""
    _last_part: str = ""

    def write(self, gaps: Iterator[str]) -> None:
        """Write all, and finish the file."""
        self.gaps += gaps
        self._write_head()
        for part in self.parts:
            copier = MessageCopier(self.file)
            is_first = True
            for record in part.mcap_records():
                if not isinstance(record, Message):
                    copier.learn(record)
                    continue
                if copier.topic(record) == part.topic(TICK.name):
                    self._meet(part, record, is_first=is_first)
                    is_first = False
                self.messages += copier.copy(record)
        self.file.describe(JOINED, self._account())
        self.file.finish()

    def _write_head(self) -> None:
        first = self.parts[0]
        for name, document in first.metadata.items():
            if name not in (PART, END):
                self.file.describe(name, document)
        if missing := _missing(self.parts):
            self.file.describe(END, missing)
        for name, data in first.attachments.items():
            self.file.attach(name, media_type_of(name), data)
        self._attach_served(set(first.attachments))

    def _attach_served(self, attached: set[str]) -> None:
        """Attach who took over meanwhile: the swap may stand in a part that is missing."""
        for part in self.parts[1:]:
            for name in part.attachments:
                if name.startswith(ATTACHED_BESIDE) and name not in attached:
                    self.file.attach(name, media_type_of(name), part.attachments[name])
                    attached.add(name)

    def _meet(self, part: Log, record: Message, *, is_first: bool) -> None:
        """Count a tick; where a part begins, look what lies between it and the one before."""
        index = Tick.FromString(record.data).decision.index
        if is_first and self._last is not None:
            between = f"between {self._last_part} and {part.path.name}"
            if index <= self._last:
                raise LogError(
                    f"{part.path}: expected tick {self._last + 1} or a later one, got tick {index},"
                    f" which stands in {self._last_part} as well; one of them is a copy"
                )
            if index > self._last + 1:
                self.gaps.append(f"ticks {self._last + 1} to {index - 1}, {between}")
        self._last, self._last_part = index, part.path.name
        self.ticks += 1

    def _account(self) -> Mapping[str, str]:
        return {
            "parts": ", ".join(part.path.name for part in self.parts),
            "missing": "; ".join(self.gaps),
        }


def _missing(parts: list[Log]) -> dict[str, str]:
    """What the parts say is missing in their middles, together."""
    total: Counter[str] = Counter()
    for part in parts:
        for kind, count in part.metadata.get(END, {}).items():
            total[kind] += int(count) if count.isdecimal() else 1
    return {kind: str(count) for kind, count in total.items()}
