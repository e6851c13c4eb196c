"""A real browser without a window: what it makes of a page."""

import shutil
import subprocess
from dataclasses import dataclass
from html.parser import HTMLParser
from pathlib import Path

import pytest

_NAMES = "chromium", "chromium-browser", "google-chrome", "google-chrome-stable"
_LIMIT_S = 180


@dataclass(frozen=True)
class Seen:
    """A page as the browser has it after its scripts ran."""

    title: str
    board: list[list[str]]
    """The leaderboard's rows, cell by cell."""
    scripts: int
    complaints: list[str]
    """What the console says."""


def browser() -> str:
    """The browser's program; without one the test is left out."""
    found = next(filter(None, map(shutil.which, _NAMES)), None)
    if found is None:
        pytest.skip(f"no browser on PATH, of {', '.join(_NAMES)}")
    return found


def opened(page: Path, profile: Path) -> Seen:
    """Open a page; its address is a file's."""
    said = _run(page, profile, "--dump-dom", "--enable-logging=stderr")
    reader = _Reader()
    reader.feed(said.stdout)
    complaints = [line for line in said.stderr.splitlines() if ":CONSOLE" in line]
    return Seen(reader.title, reader.board, reader.scripts, complaints)


def screenshot(page: Path, picture: Path, profile: Path) -> None:
    """What it looks like, 1300 pixels wide."""
    _run(page, profile, f"--screenshot={picture}", "--window-size=1300,2000", "--hide-scrollbars")


def _run(page: Path, profile: Path, *flags: str) -> subprocess.CompletedProcess[str]:
    words = [browser(), "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"]
    words += [f"--user-data-dir={profile}", *flags, page.as_uri()]
    return subprocess.run(words, capture_output=True, text=True, timeout=_LIMIT_S, check=True)


class _Reader(HTMLParser):
    """The title, and the cells of the table `board`."""

    def __init__(self) -> None:
        super().__init__()
        self.title, self.scripts = "", 0
        self.board: list[list[str]] = []
        self._open: list[str] = []
        self._in_board = False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._open.append(tag)
        self.scripts += tag == "script"
        self._in_board |= tag == "table" and ("id", "board") in attrs
        if self._in_body and tag == "tr":
            self.board.append([])
        if self._in_body and tag in ("td", "th"):
            self.board[-1].append("")

    def handle_endtag(self, tag: str) -> None:
        while self._open and self._open.pop() != tag:
            pass
        if tag == "table":
            self._in_board = False

    def handle_data(self, data: str) -> None:
        if self._open and self._open[-1] == "title" and "svg" not in self._open:
            self.title += data
        if self._in_body and self.board and self.board[-1] and "title" not in self._open:
            self.board[-1][-1] += data

    @property
    def _in_body(self) -> bool:
        return self._in_board and "tbody" in self._open
