"""Words from outside, such as names of files and topics: how they are shown, and pasted.

A terminal obeys the control characters in what is written to it, and a name out of the file system
may hold bytes that are no character (lone surrogates), which nothing can write.
"""

import os
import shlex
from pathlib import PurePath

_LAID_OUT = "\n\t"
_ITSELF = frozenset(chr(code) for code in range(0x20, 0x7F)) - set("'\\")


def shown(text: str) -> str:
    """Text in which what cannot be seen is an escape; lines stay lines."""
    return "".join(c if c.isprintable() or c in _LAID_OUT else ascii(c)[1:-1] for c in text)


def plain(text: str) -> str:
    """The same on one line: for a name."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


def pasteable(*words: object) -> str:
    """A command line in which names of files are quoted, whatever stands in them.

    A file whose name begins with a dash would be taken for a flag, so it is written as a path.
    """
    return " ".join(map(_quoted, words))


def _quoted(word: object) -> str:
    text = str(word)
    if isinstance(word, PurePath) and text.startswith("-"):
        text = f"./{text}"
    if text.isprintable():
        return shlex.quote(text)
    return "$'" + "".join(map(_escaped, os.fsencode(text))) + "'"


def _escaped(byte: int) -> str:
    character = chr(byte)
    return character if character in _ITSELF else f"\\x{byte:02x}"
