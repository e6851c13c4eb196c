"""Dataclasses filled from TOML, strictly: whatever is off names its line and its field.

A table becomes a dataclass, whose fields say which keys there are, of which type, and which may be
missing. Annotations understood: float, int, str, a `StrEnum`, a dataclass, `X | None`, a tuple of
fixed length, `tuple[X, ...]`, and a union of dataclasses, among which `kind = "second-sender"`
chooses the class `SecondSender`. Where a list of lists is expected, one list stands for its only
element. Dataclasses check their values themselves; what they refuse is told with its line.
"""

import dataclasses
import re
import reprlib
from collections.abc import Callable, Mapping
from enum import StrEnum
from functools import cache
from types import NoneType, UnionType
from typing import Any, Never, TypeAlias, TypeVar, Union, get_args, get_origin, get_type_hints

from reflexarc_runtime.config.toml_lines import KeyPath, dotted
from reflexarc_runtime.config.toml_source import TomlSource
from reflexarc_runtime.errors import ReflexarcError

Resolve: TypeAlias = Callable[[object, type, KeyPath], object]
"""Makes a number of what stands for one: (value, int or float, path) → the number, or the value.

Raises:
    ValueError: it stands for no number; the message says what was expected.
"""

_T = TypeVar("_T")

_MOST_INT = 1 << 64
_COUNTS = {2: "two", 3: "three"}
_WORDS: Mapping[Any, str] = {float: "number", int: "whole number", str: "text"}


def fill(kind: type[_T], source: TomlSource, resolve: Resolve = lambda value, *_: value) -> _T:
    """A whole document as a dataclass.

    Args:
        kind: the dataclass.
        source: the document.
        resolve: what may stand in place of a number; nothing by default.

    Raises:
        ReflexarcError: of the source's class: a key is missing, unknown, of the wrong type or out
            of range.
    """
    filled: _T = _Filling(source, resolve).table(kind, source.document, ())
    return filled


@dataclasses.dataclass(frozen=True)
class _Filling:
    """From tables and values to dataclasses and theirs; `path` is always where the value stands."""

    source: TomlSource
    resolve: Resolve

    def table(self, kind: Any, value: object, path: KeyPath) -> Any:
        """A dataclass."""
        table, fields = self._require_table(value, path), _fields(kind)
        for name in table:
            if name not in fields:
                self._refuse((*path, name), f"unknown; known: {', '.join(fields)}")
        for name, (hint, is_required) in fields.items():
            if is_required and name not in table:
                self._refuse((*path, name), f"missing; expected {_described(hint, name)}")
        values = {name: self.value(fields[name][0], v, (*path, name)) for name, v in table.items()}
        try:
            return kind(**values)
        except ReflexarcError as error:
            raise self._relocated(error, kind, path) from None

    def value(self, hint: Any, value: object, path: KeyPath) -> object:
        """Whatever an annotation asks for."""
        if get_origin(hint) is tuple:
            return self._tuple(hint, value, path)
        if get_origin(hint) in (Union, UnionType):
            return self._one_of(hint, value, path)
        if dataclasses.is_dataclass(hint):
            return self.table(hint, value, path)
        scalar = self._scalar(hint, value, path)
        if scalar is None:
            self._refuse_type(hint, value, path)
        return scalar

    def _one_of(self, hint: Any, value: object, path: KeyPath) -> object:
        """One of several dataclasses, by its kind; or the only thing beside None."""
        arms = [arm for arm in get_args(hint) if arm is not NoneType]
        if len(arms) == 1:
            return self.value(arms[0], value, path)
        table = dict(self._require_table(value, path))
        kinds = {_in_kebab_case(arm.__name__): arm for arm in arms}
        name = table.pop("kind", None)
        if not isinstance(name, str) or name not in kinds:
            got = "none" if name is None else _shown(name)
            self._refuse((*path, "kind"), f"expected one of {', '.join(kinds)}, got {got}")
        return self.table(kinds[name], table, path)

    def _tuple(self, hint: Any, value: object, path: KeyPath) -> tuple[object, ...]:
        """A list; of fixed length only if it holds nothing but numbers or texts."""
        inner, length = _elements(hint)
        if not isinstance(value, list):
            self._refuse_type(hint, value, path)
        if length is None:
            is_one = get_origin(inner) is tuple and value and not isinstance(value[0], list)
            items = [value] if is_one else value
            return tuple(self.value(inner, item, (*path, n)) for n, item in enumerate(items))
        scalars = tuple(self._scalar(inner, item, (*path, n)) for n, item in enumerate(value))
        if len(scalars) != length or None in scalars:
            self._refuse_type(hint, value, path)
        return scalars

    def _scalar(self, hint: Any, value: object, path: KeyPath) -> object:
        """The value as a number, a text or a choice; None if it is none."""
        if hint in (float, int):
            try:
                return _number(hint, self.resolve(value, hint, path))
            except ValueError as reason:
                self._refuse(path, str(reason))
        if issubclass(hint, StrEnum):
            return next((choice for choice in hint if choice == value), None)
        return value if isinstance(value, hint) else None

    def _require_table(self, value: object, path: KeyPath) -> dict[str, object]:
        if not isinstance(value, dict):
            self._refuse(path, f"expected a table, [{_header(path)}], got {_shown(value)}")
        return value

    def _relocated(self, error: ReflexarcError, kind: Any, path: KeyPath) -> ReflexarcError:
        """What a dataclass refused, at the field that it names before its colon."""
        where, _, words = str(error).partition(": ")
        parts = re.findall(r"\w+", where)
        for first, name in enumerate(parts):
            if name in _fields(kind):
                inner = [int(part) if part.isdecimal() else part for part in parts[first:]]
                return self.source.complaint((*path, *inner), words)
        return self.source.complaint(path, str(error))

    def _refuse_type(self, hint: Any, value: object, path: KeyPath) -> Never:
        self._refuse(path, f"expected {_described(hint, _header(path))}, got {_shown(value)}")

    def _refuse(self, path: KeyPath, words: str) -> Never:
        raise self.source.complaint(path, words)


def _number(hint: type, value: object) -> float | None:
    """The value as an int or a float; None if it is none, or beyond all that a number is for."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    if isinstance(value, int) and abs(value) > _MOST_INT:
        return None
    if hint is float:
        return float(value)
    return value if isinstance(value, int) else None


def _described(hint: Any, header: str) -> str:
    """What an annotation asks for, in words; `header` is where a table would stand."""
    if get_origin(hint) in (Union, UnionType) or dataclasses.is_dataclass(hint):
        return f"a table, [{header}]"
    if get_origin(hint) is tuple:
        inner, length = _elements(hint)
        if length is not None:
            return f"{_COUNTS.get(length, length)} {_WORDS[inner]}s"
        if inner in _WORDS:
            return f"a list of {_WORDS[inner]}s"
        if get_origin(inner) is tuple:
            return f"a list of {_described(inner, header)}, or several of them"
        return f"tables, each under [[{header}]]"
    if issubclass(hint, StrEnum):
        return " or ".join(hint) if len(hint) == 2 else f"one of {', '.join(hint)}"
    return f"a {_WORDS[hint]}"


def _elements(hint: Any) -> tuple[Any, int | None]:
    """Type of a tuple's elements, and how many there are; None for any number."""
    arms = get_args(hint)
    return arms[0], None if arms[-1] is Ellipsis else len(arms)


@cache
def _fields(kind: Any) -> Mapping[str, tuple[Any, bool]]:
    """The annotation of each field, and whether it must be given."""
    hints, missing = get_type_hints(kind), dataclasses.MISSING
    return {
        field.name: (hints[field.name], field.default is field.default_factory is missing)
        for field in dataclasses.fields(kind)
    }


def _header(path: KeyPath) -> str:
    """A path as a header writes it, without indices."""
    return dotted(tuple(part for part in path if isinstance(part, str)))


def _in_kebab_case(name: str) -> str:
    return re.sub(r"(?<!^)(?=[A-Z])", "-", name).lower()


def _shown(value: object) -> str:
    """A value in a message: short, whatever it is, and on one line."""
    return reprlib.repr(value)
