"""A small TOML file as it came: its text, what it says, and on which line it says it."""

import codecs
import re
import tomllib
from pathlib import Path
from typing import Any

from reflexarc_runtime.config.key_path import KeyPath, dotted, without_indices
from reflexarc_runtime.config.toml_lines import key_lines, line_of
from reflexarc_runtime.errors import ReflexarcError, UsageError
from reflexarc_runtime.files import is_lfs_pointer

MAX_BYTES = 64 * 1024
"""The largest file that is read; those of people have a few KiB."""
_UTF16 = codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE
MAX_LINE = 2000
"""Characters. A key of 30,000 parts would keep `tomllib` busy for half a minute."""


def read_text(path: Path, name: str, error: type[ReflexarcError] = UsageError) -> str:
    """The text of a small file, as it would be without the marks of Windows.

    An editor there begins it with a byte order mark, and ends lines with two characters.

    Args:
        path: where it is.
        name: how complaints name it.
        error: what to raise.

    Raises:
        ReflexarcError: of the given class: unreadable, too large, or no UTF-8.
    """
    try:
        with path.open("rb") as file:
            content = file.read(MAX_BYTES + 1)
    except OSError as reason:
        raise error(f"{name}: cannot be read: {reason.strerror}; give a TOML file") from None
    except ValueError:  # a NUL in the name
        raise error(f"{name!r}: expected the name of a TOML file") from None
    if is_lfs_pointer(content):
        raise error(f"{name}: is a Git LFS pointer, not the file itself: git lfs pull")
    if len(content) > MAX_BYTES:
        raise error(f"{name}: expected at most {MAX_BYTES // 1024} KiB of TOML, got more")
    if content.startswith(_UTF16):
        raise error(
            f"{name}:1: expected TOML in UTF-8, got UTF-16, as its byte order mark says; "
            "save it as UTF-8"
        )
    try:
        return content.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as reason:
        line = content.count(b"\n", 0, reason.start) + 1
        raise error(f"{name}:{line}: expected TOML in UTF-8, got other bytes") from None


class TomlSource:
    """A TOML text, and how to complain about it.

    Args:
        text: the TOML.
        name: how complaints name it; without a name they give the line alone.
        error: what they are.

    Raises:
        ReflexarcError: of the given class: it is no TOML.
    """

    def __init__(self, text: str, name: str = "", error: type[ReflexarcError] = UsageError) -> None:
        self.text = text
        self._name, self._error = name, error
        for number, line in enumerate(text.split("\n"), start=1):
            if len(line) > MAX_LINE:
                raise self._on_line(number, f"expected at most {MAX_LINE} characters, got more")
        self.document = self._parsed()

    def complaint(self, path: KeyPath, words: str) -> ReflexarcError:
        """The error for what stands at a path, with its line."""
        where = f"{dotted(path)}: " if path else ""
        return self._on_line(line_of(path, key_lines(self.text)), where + words)

    def one_table(self, path: KeyPath) -> str:
        """What a dataclass is filled from."""
        return f"a table, [{without_indices(path)}]"

    def many_tables(self, path: KeyPath) -> str:
        """What a tuple of dataclasses is filled from."""
        return f"tables, each under [[{without_indices(path)}]]"

    def _parsed(self) -> dict[str, Any]:
        try:
            return tomllib.loads(self.text)
        except RecursionError:
            raise self._on_line(1, "expected TOML, got brackets within brackets for ever") from None
        except tomllib.TOMLDecodeError as reason:
            words = " ".join(str(reason).split())
            found = re.search(r"at line (\d+)", words)
            number = int(found[1]) if found else self.text.count("\n") + 1
            raise self._on_line(number, f"expected TOML: {words}") from None

    def _on_line(self, line: int, words: str) -> ReflexarcError:
        place = f"{self._name}:{line}" if self._name else f"line {line}"
        return self._error(f"{place}: {words}")
