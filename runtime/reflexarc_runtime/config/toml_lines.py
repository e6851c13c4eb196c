"""On which line of a TOML text each key and each table stands.

Python's `tomllib` gives values without lines. This module goes over a text that `tomllib` has
accepted: it cuts the text into statements (a header, or a key with its value) and lets `tomllib`
read each header and each key alone. What stands within a value, such as an inline table, is on its
statement's line.
"""

import re
import tomllib
from collections.abc import Iterator, Mapping
from typing import Any

from reflexarc_runtime.config.key_path import KeyPath

_TOKEN = re.compile(
    r'#[^\n]*|"{3}(?:\\.|[^\\])*?"{3,5}|\'{3}.*?\'{3,5}|"(?:\\.|[^"\\\n])*"|\'[^\'\n]*\'|.',
    re.DOTALL,
)
"""A comment, a string of one of the four kinds, or any other character."""

_DEEPEST = 20
"""Keys on the way to a value whose line is noted; no document of ours has half as many."""


def key_lines(text: str) -> Mapping[KeyPath, int]:
    """The line, from 1 on, of every header and every key outside of a value."""
    lines: dict[KeyPath, int] = {}
    lengths: dict[KeyPath, int] = {}
    table: KeyPath = ()
    for line, words in _statements(text):
        keys = _keys_of(words)
        if not words.startswith("["):
            path = (*table, *keys)
        else:
            table = path = _opened(keys, lengths, is_array=words.startswith("[["))
        for depth in range(1, min(len(path), _DEEPEST) + 1):
            lines.setdefault(path[:depth], line)
    return lines


def line_of(path: KeyPath, lines: Mapping[KeyPath, int]) -> int:
    """The line of a value: its own, or that of the nearest thing around it."""
    depths = range(min(len(path), _DEEPEST), 0, -1)
    return next((lines[path[:depth]] for depth in depths if path[:depth] in lines), 1)


def _statements(text: str) -> Iterator[tuple[int, str]]:
    """Line and words of each statement, of a value only its beginning."""
    line = begins = 1
    depth, has_value, words = 0, False, ""
    for match in _TOKEN.finditer(text):
        token = match[0]
        if token == "\n" and depth == 0:
            if words.strip():
                yield begins, words.strip()
            depth, has_value, words, begins = 0, False, "", line + 1
        depth += (token in ("[", "{")) - (token in ("]", "}"))
        has_value = has_value or token == "="
        if not has_value and not token.startswith("#"):
            words += token
        line += token.count("\n")
    if words.strip():
        yield begins, words.strip()


def _keys_of(words: str) -> tuple[str, ...]:
    """The keys of a header, or of a statement up to its `=`."""
    node: Any = tomllib.loads(words if words.startswith("[") else f"{words} = 0")
    keys: list[str] = []
    while node:
        ((key, node),) = node.items()
        keys.append(key)
        node = node[0] if isinstance(node, list) else node
    return tuple(keys)


def _opened(keys: tuple[str, ...], lengths: dict[KeyPath, int], *, is_array: bool) -> KeyPath:
    """The table that a header opens; a key of an array of tables means its last table."""
    path: KeyPath = ()
    for key in keys[:-1]:
        path = (*path, key)
        path = (*path, lengths[path] - 1) if path in lengths else path
    path = (*path, keys[-1])
    if is_array:
        lengths[path] = lengths.get(path, 0) + 1
        return (*path, lengths[path] - 1)
    return path
