"""Dataclasses filled from mappings, strictly: a complaint names the field, and in TOML its line.

A table becomes a dataclass, whose fields say which keys there are, of which type, and which may be
missing. Annotations understood: float, int, str, bool, a `StrEnum`, a `Literal` of texts, a
dataclass, `X | None`, a tuple of fixed length, `tuple[X, ...]`, `Mapping[str, X]`, `object` and
`Any` (taken as they are), and a union of dataclasses, among which `kind = "second-sender"` chooses
the class `SecondSender`. Where a list of lists of fixed length is expected, one list stands for its
only element. Dataclasses check their values themselves; what they refuse is told with its place.
"""

import dataclasses
import re
import reprlib
from collections.abc import Callable, Mapping
from types import NoneType
from typing import Any, Never, TypeAlias, TypeVar, get_args, get_origin

from reflexarc_runtime.config.annotations import (
    arms_of,
    choices_of,
    described,
    elements_of,
    fields_of,
    is_fixed_tuple,
    is_union,
)
from reflexarc_runtime.config.key_path import KeyPath
from reflexarc_runtime.config.source import Source
from reflexarc_runtime.errors import ReflexarcError

_MOST_INT = 1 << 128
"""Larger numbers are refused by their type: they overflow a float, or fill a screen."""

_FIELD = re.compile(r"\w+(\.\w+|\[\d+\])*")
"""A field as complaints name it, unlike the path of a file: `world.width_m`, `wheels[1]`."""

Resolve: TypeAlias = Callable[[object, type, KeyPath], object]
"""Makes a number of what stands for one: (value, int or float, path) → the number, or the value.

A whole number where one is expected stands for itself and may not be handed over.

Raises:
    ValueError: it stands for no number; the message says what was expected.
"""

_T = TypeVar("_T")


def fill(
    kind: type[_T],
    source: Source,
    resolve: Resolve = lambda value, *_: value,
    *,
    ignore_unknown: bool = False,
    require_all: bool = False,
) -> _T:
    """A whole document as a dataclass.

    Args:
        kind: the dataclass.
        source: the document.
        resolve: what may stand in place of a number; nothing by default.
        ignore_unknown: keys that no field has are left out; by default they are refused.
        require_all: fields with a default must be given, too.

    Raises:
        ReflexarcError: of the source's class: a key is missing, unknown, of the wrong type or out
            of range.
    """
    filling = _Filling(source, resolve, ignore_unknown, require_all)
    filled: _T = filling.table(kind, source.document, ())
    return filled


def converted(hint: Any, value: object, source: Source, path: KeyPath) -> Any:
    """One value as the field with that annotation takes it.

    Args:
        hint: the annotation.
        value: the value.
        source: what complains.
        path: where the value stands.

    Raises:
        ReflexarcError: of the source's class: it is of the wrong type.
    """
    return _Filling(source, lambda value, *_: value).value(hint, value, path)


@dataclasses.dataclass(frozen=True)
class _Filling:
    """From tables and values to dataclasses and theirs; `path` is always where the value stands."""

    source: Source
    resolve: Resolve
    ignore_unknown: bool = False
    require_all: bool = False

    def table(self, kind: Any, value: object, path: KeyPath) -> Any:
        """A dataclass."""
        table, fields = self._require_table(value, path), fields_of(kind)
        self._check_keys(table, fields, path)
        values = {
            name: self.value(fields[name][0], item, (*path, name))
            for name, item in table.items()
            if name in fields
        }
        try:
            return kind(**values)
        except ReflexarcError as error:
            raise self._relocated(error, kind, path) from None

    def value(self, hint: Any, value: object, path: KeyPath) -> object:
        """Whatever an annotation asks for."""
        if hint is int and type(value) is int and -_MOST_INT <= value <= _MOST_INT:
            return value  # thousands of them in a contract's golden vectors
        if hint in (Any, object):
            return value
        if get_origin(hint) is tuple:
            return self._tuple(hint, value, path)
        if is_union(hint):
            return self._one_of(hint, value, path)
        if get_origin(hint) is Mapping:
            return self._mapping(hint, value, path)
        if dataclasses.is_dataclass(hint):
            return self.table(hint, value, path)
        scalar = self._scalar(hint, value, path)
        if scalar is None:
            self._refuse_type(hint, value, path)
        return scalar

    def _one_of(self, hint: Any, value: object, path: KeyPath) -> object:
        """One of several dataclasses, by its kind; or None, or the only thing beside it."""
        if value is None and NoneType in get_args(hint):
            return None
        arms = arms_of(hint)
        if len(arms) == 1:
            (only,) = arms.values()
            return self.value(only, value, path)
        table = dict(self._require_table(value, path))
        name = table.pop("kind", None)
        if not isinstance(name, str) or name not in arms:
            got = "none" if name is None else _shown(name)
            self._refuse((*path, "kind"), f"expected one of {', '.join(arms)}, got {got}")
        return self.table(arms[name], table, path)

    def _mapping(self, hint: Any, value: object, path: KeyPath) -> dict[str, object]:
        """A dictionary whose keys are free."""
        inner, table = get_args(hint)[1], self._require_table(value, path)
        return {name: self.value(inner, item, (*path, name)) for name, item in table.items()}

    def _tuple(self, hint: Any, value: object, path: KeyPath) -> tuple[object, ...]:
        """A list; of fixed length only if it holds nothing but numbers or texts."""
        inner, length = elements_of(hint)
        if not isinstance(value, list):
            self._refuse_type(hint, value, path)
        if length is None:
            is_one = is_fixed_tuple(inner) and value and not isinstance(value[0], list)
            items = [value] if is_one else value
            return tuple(self.value(inner, item, (*path, n)) for n, item in enumerate(items))
        scalars = tuple(self._scalar(inner, item, (*path, n)) for n, item in enumerate(value))
        if len(scalars) != length or None in scalars:
            self._refuse_type(hint, value, path)
        return scalars

    def _scalar(self, hint: Any, value: object, path: KeyPath) -> object:
        """The value as a number, a text or a choice; None if it is of another type."""
        if hint in (float, int):
            try:
                return _number(hint, self.resolve(value, hint, path))
            except ValueError as reason:
                self._refuse(path, str(reason))
        if choices := choices_of(hint):
            return next((choice for choice in choices if choice == value), None)
        return value if isinstance(value, hint) else None

    def _check_keys(
        self, table: Mapping[str, object], fields: Mapping[str, tuple[Any, bool]], path: KeyPath
    ) -> None:
        for name in table:
            if name not in fields and not self.ignore_unknown:
                self._refuse((*path, name), f"unknown; known: {', '.join(fields)}")
        for name, (hint, has_no_default) in fields.items():
            if name not in table and (has_no_default or self.require_all):
                at = (*path, name)
                self._refuse(at, f"missing; expected {described(hint, self.source, at)}")

    def _require_table(self, value: object, path: KeyPath) -> Mapping[str, object]:
        if not isinstance(value, Mapping):
            self._refuse(path, f"expected {self.source.one_table(path)}, got {_shown(value)}")
        return value

    def _relocated(self, error: ReflexarcError, kind: Any, path: KeyPath) -> ReflexarcError:
        """What a dataclass refused, at the field that it names before its colon, if it does."""
        where, _, words = str(error).partition(": ")
        names_a_field = words and _FIELD.fullmatch(where)
        parts = re.findall(r"\w+", where) if names_a_field else []
        for first, name in enumerate(parts):
            if name in fields_of(kind):
                inner = [int(part) if part.isdecimal() else part for part in parts[first:]]
                return self.source.complaint((*path, *inner), words)
        return self.source.complaint(path, str(error))

    def _refuse_type(self, hint: Any, value: object, path: KeyPath) -> Never:
        self._refuse(path, f"expected {described(hint, self.source, path)}, got {_shown(value)}")

    def _refuse(self, path: KeyPath, words: str) -> Never:
        raise self.source.complaint(path, words)


def _number(hint: type, value: object) -> float | None:
    """The value as an int or a float; None if it is of another type, or too large for any use."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    if isinstance(value, int) and abs(value) > _MOST_INT:
        return None
    if hint is float:
        return float(value)
    return value if isinstance(value, int) else None


def _shown(value: object) -> str:
    """A value in a message: short, whatever it is, and on one line."""
    return reprlib.repr(value)
