"""Which parts a recording has, and what became of each: `NAME.parts.jsonl` beside them.

One event a line, in the order in which they happened, only ever added to: a process that is killed
loses no more than its last line. What happened to a file later, by somebody else's hand, is not in
it; so whether a part is there is a matter of the disk.

    {"at": "2026-03-01T10:00:00.000Z", "event": "recording", "first": "drive.mcap", "run_id": "…"}
    {"at": …, "event": "begun", "part": 2, "name": "drive.part2.mcap", "after": "60 s"}
    {"at": …, "event": "finished", "part": 2, "name": "drive.part2.mcap", "bytes": 1048576}
    {"at": …, "event": "removed", "part": 1, "name": "drive.mcap", "bytes": …, "by": …, "why": …}

A recording that was given a folder, and not a name, says so with its kind and its number in it. Its
recorder holds a lock (flock) on the manifest for as long as it lives: only then, and once nobody
holds it, do later recordings of that folder count its parts as theirs to remove.

    {"at": …, "event": "recording", "first": …, "run_id": …, "folder": "whole run", "number": 7}
    {"at": …, "event": "removed before", "name": …, "of": …, "bytes": …, "by": …, "why": …}
    {"at": …, "event": "forgotten", "name": "drive.parts.jsonl", "by": …, "why": …}
"""

import datetime
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, TypeAlias, get_args

from reflexarc_runtime.errors import LogError

MANIFEST = ".parts.jsonl"
_LONGEST_HEAD_BYTES = 4096

PartEvent: TypeAlias = Literal["begun", "finished", "failed", "removed", "left"]
"""`left`: it should have been removed, and was not."""
Event: TypeAlias = PartEvent | Literal["recording", "removed before", "forgotten"]
"""`removed before`: an earlier recording's part; `forgotten`: its manifest, once all are gone."""
RECORDING: Literal["recording"] = "recording"
_EVENTS: dict[str, PartEvent] = {event: event for event in get_args(PartEvent)}


@dataclass(frozen=True)
class ListedPart:
    """One part, as a manifest says."""

    number: int
    path: Path
    """The name that it has, or would have, when it is finished."""
    state: PartEvent
    why: str = ""
    """Why it was begun; of one that was removed or failed, why that."""
    size_bytes: int | None = None
    """Once it has ended."""


@dataclass(frozen=True)
class ListedRecording:
    """What a manifest says of its last recording."""

    run_id: str = ""
    folder: str = ""
    """Which kind of recordings of its folder it belongs to; empty: it was given a name."""
    number: int = 0
    """Of the recording in its folder: the order of their starts, whatever a clock says."""
    parts: tuple[ListedPart, ...] = ()


class Manifest:
    """Writes the manifest of one recording. Nothing is written before `begin`.

    Args:
        first: the first part.
        run_id: whose recording it is.
        facts: more that is said of it.
    """

    def __init__(self, first: Path, run_id: str, **facts: str | int) -> None:
        self.path = manifest_of(first)
        self._unsaid: list[str] | None = []
        self.say(RECORDING, first=first.name, run_id=run_id, **facts)

    def begin(self) -> None:
        """Write what was said so far; from now on all is written at once.

        Raises:
            OSError: the disk did not take it.
        """
        unsaid, self._unsaid = self._unsaid, None
        self._write("".join(unsaid or ()))

    def say(self, event: Event, **facts: str | int) -> None:
        """Add one event.

        Raises:
            OSError: the disk did not take it.
        """
        line = _line(event, facts)
        if self._unsaid is None:
            self._write(line)
        else:
            self._unsaid.append(line)

    def _write(self, line: str) -> None:
        with self.path.open("a", encoding="utf-8") as file:
            file.write(line)


def say_in(path: Path, event: Event, **facts: str | int) -> None:
    """Add an event to the manifest of a recording that has ended, in place of a line cut by a kill.

    Raises:
        OSError: it is no longer there, or the disk did not take it.
    """
    with path.open("r+b") as file:
        file.seek(file.read().rfind(b"\n") + 1)
        file.truncate()
        file.write(_line(event, facts).encode())


def _line(event: Event, facts: Mapping[str, str | int]) -> str:
    now = datetime.datetime.now(datetime.UTC).isoformat(timespec="milliseconds")
    return json.dumps({"at": now.replace("+00:00", "Z"), "event": event, **facts}) + "\n"


def manifest_of(first: Path) -> Path:
    """Where the manifest of a recording is: `drive.mcap` has `drive.parts.jsonl`."""
    return first.with_name(first.stem + MANIFEST)


def read_manifest(path: Path) -> tuple[ListedPart, ...]:
    """The parts of the last recording that a manifest tells of, by number.

    Raises:
        LogError: it cannot be read, or is no manifest.
    """
    return read_recording(path).parts


def read_recording(path: Path) -> ListedRecording:
    """The last recording that a manifest tells of.

    Raises:
        LogError: it cannot be read, or is no manifest.
    """
    said, parts = ListedRecording(), dict[int, ListedPart]()
    for number, event in _events(path):
        try:
            if event["event"] == RECORDING:
                said = _recording(event)
                parts.clear()
            else:
                _apply(event, parts, path.parent)
        except (KeyError, TypeError, ValueError, OverflowError):
            raise LogError(f"{path}, line {number}: expected an event of a recording") from None
    return replace(said, parts=tuple(parts[number] for number in sorted(parts)))


def read_head(path: Path) -> ListedRecording:
    """What the first line of a manifest says, without its parts; nothing, if it says nothing."""
    try:
        with path.open("rb") as file:
            event = json.loads(file.readline(_LONGEST_HEAD_BYTES))
            return _recording(event) if event["event"] == RECORDING else ListedRecording()
    except (OSError, KeyError, TypeError, ValueError, OverflowError, RecursionError):
        return ListedRecording()


def _events(path: Path) -> Iterator[tuple[int, dict[str, Any]]]:
    try:
        lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    except (OSError, UnicodeDecodeError) as error:
        raise LogError(f"{path}: cannot be read: {error}") from None
    for number, line in enumerate(lines, 1):
        try:
            yield number, json.loads(line)
        except (ValueError, RecursionError):
            if number < len(lines) or line.endswith("\n"):
                raise LogError(f"{path}, line {number}: expected JSON") from None
            return  # killed while it wrote this line


def _recording(event: dict[str, Any]) -> ListedRecording:
    return ListedRecording(
        run_id=str(event.get("run_id", "")),
        folder=str(event.get("folder", "")),
        number=int(event.get("number", 0)),
    )


def _apply(event: dict[str, Any], parts: dict[int, ListedPart], folder: Path) -> None:
    kind = _EVENTS.get(event["event"])
    if kind is None:
        return  # a newer version has more
    number, name = int(event["part"]), str(event["name"])
    if Path(name).name != name:
        raise ValueError(name)  # a part is beside its manifest, nowhere else
    why = str(event.get("why") or event.get("after") or "")
    known = parts.get(number, ListedPart(number, folder / name, kind, why))
    size_bytes = int(event["bytes"]) if "bytes" in event else known.size_bytes
    parts[number] = replace(known, state=kind, why=why or known.why, size_bytes=size_bytes)
