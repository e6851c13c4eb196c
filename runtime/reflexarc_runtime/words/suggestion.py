"""Commands that a message suggests, so that they can be pasted into a shell."""

import os
import shlex
from pathlib import PurePath

_ITSELF = frozenset(chr(code) for code in range(0x20, 0x7F)) - set("'\\")


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
