"""The logs that a project names as its tests, and which of them a run of pytest reaches.

A net that catches nothing says so: a place that is missing or holds no log is an error, and so is
a log that a run of all tests leaves out without having been told to.
"""

import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fnmatch import fnmatch
from glob import has_magic
from pathlib import Path

LOG_SUFFIX = ".mcap"
_LONGEST_LINK = 4096
"""Bytes of the longest path that Linux follows."""


@dataclass(frozen=True)
class WhatRuns:
    """What a run of pytest was told to collect."""

    places: Sequence[Path]
    is_whole: bool
    """Whether nobody named any: all tests of the project."""
    ignored: Sequence[Path] = ()
    """By `--ignore`."""
    ignored_patterns: Sequence[str] = ()
    """By `--ignore-glob`."""

    def ignores(self, log: Path) -> bool:
        """Whether the run was told to leave a log out."""
        if any(log.is_relative_to(path) for path in self.ignored):
            return True
        above = (log, *log.parents)
        return any(fnmatch(str(path), glob) for path in above for glob in self.ignored_patterns)


class NetError(Exception):
    """A place without a log, or a log that no test replays."""


def named_logs(root: Path, places: Iterable[str]) -> list[Path]:
    """All logs at the named places, links followed; absolute, as pytest will meet them.

    Raises:
        NetError: a place is missing, or holds no log.
    """
    found: dict[Path, None] = {}
    for place in places:
        logs = [log for path in _paths(root, place) for log in _logs_at(path)]
        if not logs:
            raise NetError(f"{place}: there is no log (*{LOG_SUFFIX}) in it")
        found.update(dict.fromkeys(logs))
    return list(found)


def _paths(root: Path, place: str) -> list[Path]:
    """What a place names: itself, or what a pattern fits."""
    path = Path(os.path.abspath(root / place))
    if os.path.lexists(path):
        return [path]
    fitting = sorted(root.glob(place)) if has_magic(place) and not Path(place).is_absolute() else []
    if not fitting:
        kind = "nothing fits it" if has_magic(place) else "no such folder or log"
        raise NetError(f"{place}: {kind} in {root}")
    return [Path(os.path.abspath(one)) for one in fitting]


def _logs_at(path: Path) -> Iterator[Path]:
    """The logs in a folder, or the one that it is; also links that lead nowhere."""
    if not path.is_dir():
        if path.suffix.lower() == LOG_SUFFIX:
            yield path
        return
    seen: set[str] = set()
    for folder, subfolders, names in os.walk(path, followlinks=True):
        real = os.path.realpath(folder)
        if real in seen:
            subfolders.clear()  # a link that leads back
            continue
        seen.add(real)
        subfolders.sort()
        yield from (
            Path(folder, name) for name in sorted(names) if name.lower().endswith(LOG_SUFFIX)
        )


def followed(path: Path) -> Path:
    """Where a link leads that git checked out as a file of text, for want of links; else itself."""
    with path.open("rb") as file:
        text = file.read(_LONGEST_LINK + 1)
    if len(text) > _LONGEST_LINK or not text.lower().endswith(LOG_SUFFIX.encode()):
        return path
    target = path.parent / os.fsdecode(text)
    return target if b"\n" not in text and target.is_file() else path


class LogNet:
    """Which of the named logs a run reaches.

    Args:
        logs: the named ones, absolute.
    """

    def __init__(self, logs: Sequence[Path]) -> None:
        self.logs = logs
        self.left = list(logs)
        """Those that were not collected."""
        self._same = {path: log for log in logs for path in (log, log.resolve())}

    def take(self, path: Path) -> bool:
        """Take a file that pytest collects; whether it is one of the logs."""
        log = self._same.get(path) or self._same.get(path.resolve())
        if log is None:
            return False
        if log in self.left:
            self.left.remove(log)
        return True

    def unreached(self, run: WhatRuns) -> Iterator[tuple[Path, str]]:
        """The logs that this run should have reached, each with the reason."""
        for log in self.left:
            is_inside = any(log.is_relative_to(place) for place in run.places)
            if run.ignores(log) or not (is_inside or run.is_whole):
                continue  # somebody said so; the summary counts it
            if log.is_symlink() and not log.exists():
                yield log, f"a link to {os.readlink(log)}, which is not there; fetch the store"
            elif is_inside:
                yield log, "pytest leaves it out: norecursedirs, or a conftest's collect_ignore"
            else:
                yield log, "it is not where pytest collects: add its folder to testpaths"
