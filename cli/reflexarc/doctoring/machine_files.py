"""Reads the files by which Linux tells of itself; what is not there, or not readable, is None."""

from pathlib import Path


def text_of(path: str | Path) -> str | None:
    """The text of a file, without the white space around it."""
    try:
        return Path(path).read_text(encoding="utf-8", errors="replace").strip()
    except OSError:
        return None


def number_of(path: str | Path) -> int | None:
    """The number that a file holds."""
    try:
        return int(text_of(path) or "")
    except ValueError:
        return None


def fields_of(path: str | Path) -> dict[str, str]:
    """A file of lines `name: value`."""
    lines = (line.partition(":") for line in (text_of(path) or "").splitlines())
    return {name.strip(): value.strip() for name, _, value in lines}
