"""A terminal to which no word is markup: names of files, topics and worlds come from outside.

Rich reads `[red]` and `:smile:` in what it prints, terminals obey control characters, and a stream
refuses what its encoding lacks. Here words are shown as they are, with an escape in place of what
cannot be seen; styles come from columns and tables alone.
"""

import codecs
import os
import sys
from collections.abc import MutableMapping
from io import TextIOWrapper
from typing import Any

from rich.console import Console
from rich.text import Text

from reflexarc_runtime.words.shown import shown

_FEWEST, _MOST = 20, 10_000
"""Columns, or lines, within which a table can be shown."""
_LACKED = "reflexarc.lacked"
_ASCII = str.maketrans("µ–−×·…≥≤→²₂ελ“”", 'u--x.~><>22el""')
"""What stands in for a character that a stream lacks; for any other it is a question mark."""


class PlainConsole(Console):
    """A Rich console on which words are neither markup nor orders to the terminal."""

    def __init__(self, **how: Any) -> None:
        super().__init__(highlight=False, markup=False, emoji=False, **how)

    def render_str(self, text: str, **how: Any) -> Text:
        """The words as they are shown, in prints, tables and titles alike."""
        return super().render_str(shown(text), **how)

    def on_broken_pipe(self) -> None:
        """Go on in silence: who read (`| head -1`) is gone, and the command's answer still counts.

        What this does not do is Rich's own: end with status 1.
        """
        to_nowhere(self.file)


def to_nowhere(stream: Any) -> None:
    """Let what is still written to a stream vanish."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, stream.fileno())
    os.close(nowhere)


def accept_every_word() -> None:
    """Have the standard streams write something for every character that their encoding lacks."""
    codecs.register_error(_LACKED, _stand_in)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors=_LACKED)


def forget_unusable_size(environment: MutableMapping[str, str]) -> None:
    """Remove the size of a terminal that has no room for any text, or is no number."""
    for name in ("COLUMNS", "LINES"):
        said = environment.get(name, "")
        least = _FEWEST if name == "COLUMNS" else 1
        usable = said.isascii() and said.isdigit() and len(said) <= len(str(_MOST))
        if said and not (usable and least <= int(said) <= _MOST):
            del environment[name]


def _stand_in(error: UnicodeError) -> tuple[str, int]:
    assert isinstance(error, UnicodeEncodeError)
    lacked = error.object[error.start : error.end].translate(_ASCII)
    return "".join(c if c.isascii() else "?" for c in lacked), error.end


forget_unusable_size(os.environ)  # before a console reads it
