"""What tyro says of wrong flags, as one line that says each thing once.

Tyro draws a frame: a title, what is wrong, then sections with more, and where help is. The title
says again what is wrong; the sections repeat the help of flags, also of other commands.
"""

import re
from collections.abc import Iterator
from typing import TypeAlias

_EDGES = " │"
_BELOW = "╰"
_RULE = re.compile(r"[─-]{3,}")
_NO_VALUE = re.compile(
    r"Error parsing (?P<flag>\S+): no type matching (?P<wanted>.+?) could be instantiated from "
    r"\[(?P<got>.*)\]\. Got errors:"
)
_MISPLACED = re.compile(r" \(applied to reflexarc[^)]*\)| Arguments are applied to the directly .*")
"""Tyro says it after each word; there are no subcommands of subcommands."""
_SIMILAR = re.compile(r"Perhaps you meant:|Arguments similar to")
_SAID_ELSEWHERE = "For full helptext", "Argument helptext"
_FLAG = re.compile(r"(?<![\w-])--[a-z][\w-]*")

_Section: TypeAlias = list[str]
"""The lines between two rules."""


def in_one_line(complaint: str, command: str) -> str:
    """What is wrong, what could have been meant, and which help says more.

    Args:
        complaint: the frame.
        command: the first word that was given; its own help is named where tyro names all help.
    """
    first, *others = _sections(complaint) or [complaint.split()]
    more = filter(None, [*map(_further, others), _similar(others, command)])
    is_command = "Available subcommands" not in complaint and not command.startswith("-")
    asked = f"reflexarc {command} --help" if is_command else "reflexarc --help"
    return "; ".join([_wrong(" ".join(first)), *more, f"see `{asked}`"])


def _sections(complaint: str) -> list[_Section]:
    sections: list[_Section] = [[]]
    for line in _framed(complaint):
        if _RULE.fullmatch(line):
            sections.append([])
        elif line:
            sections[-1].append(line)
    return [each for each in sections if each and not each[0].startswith(_SAID_ELSEWHERE)]


def _framed(complaint: str) -> Iterator[str]:
    """The lines within the frame, which has no sides where a terminal lacks them."""
    _title, *lines = complaint.splitlines() or [""]
    return (line.strip(_EDGES) for line in lines if not line.startswith(_BELOW))


def _wrong(said: str) -> str:
    said = _MISPLACED.sub("", said)
    found = _NO_VALUE.match(said)
    if found is not None:
        return f"{found['flag']}: expected {found['wanted'].strip('{}')}, got {found['got']}"
    return _begun_small(said.rstrip(".").replace(" Expected 1 values", " Expected one"))


def _further(section: _Section) -> str:
    return "" if _SIMILAR.match(section[0]) else _begun_small(" ".join(section))


def _similar(sections: list[_Section], command: str) -> str:
    """The flags of this command that are like those that were given."""
    lines = [line for each in sections if _SIMILAR.match(each[0]) for line in each]
    is_of_one = not any(line.startswith("in reflexarc ") for line in lines)
    flags: dict[str, None] = {}
    heard: list[str] = []
    for line in lines:
        if line.startswith("-"):
            heard = _FLAG.findall(line)
        if is_of_one or line == f"in reflexarc {command} --help":
            flags |= dict.fromkeys(heard)
    return f"similar: {', '.join(flags)}" if flags else ""


def _begun_small(words: str) -> str:
    return words[:1].lower() + words[1:]
