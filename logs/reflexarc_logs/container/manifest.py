"""Which parts a recording has, and what became of each: `NAME.parts.jsonl` beside them.

One event a line, in the order in which they happened, only ever added to: a process that is killed
loses no more than its last line. What happened to a file later, by somebody else's hand, is not in
it; so whether a part is there is a matter of the disk.

    {"at": "2026-03-01T10:00:00.000Z", "event": "recording", "first": "drive.mcap", "run_id": "…"}
    {"at": …, "event": "begun", "part": 2, "name": "drive.part2.mcap", "after": "60 s"}
    {"at": …, "event": "finished", "part": 2, "name": "drive.part2.mcap", "bytes": 1048576}
    {"at": …, "event": "removed", "part": 1, "name": "drive.mcap", "bytes": …, "by": …, "why": …}
"""

import datetime
import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, TypeAlias, get_args

from reflexarc_runtime.errors import LogError

MANIFEST = ".parts.jsonl"

PartEvent: TypeAlias = Literal["begun", "finished", "failed", "removed", "left"]
"""`left`: it should have been removed, and was not."""
Event: TypeAlias = PartEvent | Literal["recording"]
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


class Manifest:
    """Writes the manifest of one recording. Nothing is written before `begin`.

    Args:
        first: the first part.
        run_id: whose recording it is.
    """

    def __init__(self, first: Path, run_id: str) -> None:
        self.path = manifest_of(first)
        self._unsaid: list[str] | None = []
        self.say(RECORDING, first=first.name, run_id=run_id)

    def begin(self) -> None:
        """Write what was said so far; from now on all is written at once.

        Raises:
            OSError: the disk did not take it.
        """
        unsaid, self._unsaid = self._unsaid, None
        for line in unsaid or ():
            self._write(line)

    def say(self, event: Event, **facts: str | int) -> None:
        """Add one event.

        Raises:
            OSError: the disk did not take it.
        """
        now = datetime.datetime.now(datetime.UTC).isoformat(timespec="milliseconds")
        line = json.dumps({"at": now.replace("+00:00", "Z"), "event": event, **facts})
        if self._unsaid is None:
            self._write(line)
        else:
            self._unsaid.append(line)

    def _write(self, line: str) -> None:
        with self.path.open("a", encoding="utf-8") as file:
            file.write(line + "\n")


def manifest_of(first: Path) -> Path:
    """Where the manifest of a recording is: `drive.mcap` has `drive.parts.jsonl`."""
    return first.with_name(first.stem + MANIFEST)


def read_manifest(path: Path) -> tuple[ListedPart, ...]:
    """The parts of the last recording that a manifest tells of, by number.

    Raises:
        LogError: it cannot be read, or is no manifest.
    """
    parts: dict[int, ListedPart] = {}
    for number, event in _events(path):
        try:
            _apply(event, parts, path.parent)
        except (KeyError, TypeError, ValueError, OverflowError):
            raise LogError(f"{path}, line {number}: expected an event of a recording") from None
    return tuple(parts[number] for number in sorted(parts))


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


def _apply(event: dict[str, Any], parts: dict[int, ListedPart], folder: Path) -> None:
    kind = _EVENTS.get(event["event"])
    if event["event"] == RECORDING:
        parts.clear()
    if kind is None:
        return  # a newer version has more
    number, name = int(event["part"]), str(event["name"])
    if Path(name).name != name:
        raise ValueError(name)  # a part is beside its manifest, nowhere else
    why = str(event.get("why") or event.get("after") or "")
    known = parts.get(number, ListedPart(number, folder / name, kind, why))
    parts[number] = replace(known, state=kind, why=why or known.why)
