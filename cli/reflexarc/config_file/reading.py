"""Reads a command's settings from a TOML file: what the command line leaves out.

Keys are named as the flags: `rotate-s` or `rotate_s`. Relative paths are meant from the folder of
the file. What is wrong is said with its line.
"""

import dataclasses
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import UnionType
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

import tyro

from reflexarc.config_file.command_fields import NOT_IN_FILES, CommandField, fields_of_command
from reflexarc_runtime.config.fill import converted
from reflexarc_runtime.config.toml_source import TomlSource, read_text
from reflexarc_runtime.errors import UsageError

_C = TypeVar("_C")
_FLAG = "--config"


def config_in(words: list[str]) -> Path | None:
    """The file that a command line names; None if it names none.

    Raises:
        UsageError: it names two: the flags of one would be laid under those of the other.
    """
    found = list(_configs_in(words))
    if len(found) > 1:
        raise UsageError(f"{_FLAG}: expected one file, got {found[0]} and {found[1]}")
    return Path(found[0]) if found else None


def _configs_in(words: list[str]) -> Iterator[str]:
    for word, following in zip(words, [*words[1:], ""], strict=True):
        if word == "--":
            return
        if word == _FLAG and following:
            yield following
        if word.startswith(f"{_FLAG}="):
            yield word.partition("=")[2]


def settings_of(kind: type[_C], path: Path) -> _C:
    """A command with the settings of a file, and defaults where it says nothing.

    What has no default and is not in the file must be on the command line.

    Raises:
        UsageError: the file cannot be read, or holds an unknown key or a wrong value.
    """
    source = TomlSource(read_text(path, str(path)), str(path))
    known = {each.name: each for each in fields_of_command(kind)}
    given: dict[str, Any] = {}
    for key, value in source.document.items():
        name = key.replace("-", "_")
        if name not in known:
            flags = ", ".join(_as_key(name) for name in known)
            raise source.complaint((key,), f"unknown; known: {flags}")
        if name in given:
            raise source.complaint((key,), "expected once, got twice")
        given[name] = _value(known[name], key, value, source, path.parent)
    return _made(kind, given)


def _value(each: CommandField, key: str, value: Any, source: TomlSource, folder: Path) -> Any:
    """A value as the flag takes it."""
    kinds = get_args(each.hint) if _is_union(each.hint) else (each.hint,)
    if Path in kinds and isinstance(value, str):
        if not value or "\0" in value:
            raise source.complaint((key,), f"expected a path, got {value!r}")
        return folder / value
    if Path in kinds:
        raise source.complaint((key,), f"expected a path, got {value!r}")
    return converted(each.hint, value, source, (key,))


def _made(kind: type[_C], given: Mapping[str, Any]) -> _C:
    """The command and the groups within it, each with the values that are its own."""
    hints = get_type_hints(kind)
    values: dict[str, Any] = {}
    for each in dataclasses.fields(kind):  # type: ignore[arg-type]  # every command is a dataclass
        hint = hints[each.name]
        if each.name in NOT_IN_FILES:
            continue
        if dataclasses.is_dataclass(hint):
            values[each.name] = _made(hint, given)  # type: ignore[arg-type]  # a class
        elif each.name in given:
            values[each.name] = given[each.name]
        elif each.default is each.default_factory is dataclasses.MISSING:
            values[each.name] = tyro.MISSING
    return kind(**values)


def _as_key(name: str) -> str:
    return name.replace("_", "-")


def _is_union(hint: Any) -> bool:
    return get_origin(hint) is UnionType or isinstance(hint, UnionType)
