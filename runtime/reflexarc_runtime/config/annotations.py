"""What the annotation of a dataclass's field asks for: its parts, and in words."""

import dataclasses
import re
from collections.abc import Mapping
from enum import StrEnum
from functools import cache
from types import NoneType, UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

from reflexarc_runtime.config.key_path import KeyPath
from reflexarc_runtime.config.source import Source

_COUNTS = {2: "two", 3: "three"}
_WORDS: Mapping[Any, str] = {float: "number", int: "whole number", str: "text"}


@cache
def fields_of(kind: Any) -> Mapping[str, tuple[Any, bool]]:
    """The annotation of each field of a dataclass, and whether it has no default."""
    hints, missing = get_type_hints(kind), dataclasses.MISSING
    return {
        field.name: (hints[field.name], field.default is field.default_factory is missing)
        for field in dataclasses.fields(kind)
    }


def is_union(hint: Any) -> bool:
    """Whether it is `X | Y`, in either of Python's two forms."""
    return get_origin(hint) in (Union, UnionType)


def arms_of(hint: Any) -> dict[str, Any]:
    """The members of a union without None, by the names that `kind` gives them in a document."""
    return {_kind_of(arm): arm for arm in get_args(hint) if arm is not NoneType}


def elements_of(hint: Any) -> tuple[Any, int | None]:
    """Type of a tuple's elements, and how many there are; None for any number."""
    arms = get_args(hint)
    return arms[0], None if arms[-1] is Ellipsis else len(arms)


def is_fixed_tuple(hint: Any) -> bool:
    """Whether it is a tuple of fixed length."""
    return get_origin(hint) is tuple and elements_of(hint)[1] is not None


def choices_of(hint: Any) -> tuple[Any, ...]:
    """The values of a `StrEnum` or a `Literal`; none of any other annotation."""
    if get_origin(hint) is Literal:
        return get_args(hint)
    return tuple(hint) if isinstance(hint, type) and issubclass(hint, StrEnum) else ()


def described(hint: Any, source: Source, path: KeyPath) -> str:
    """What an annotation asks for, in words.

    Args:
        hint: the annotation.
        source: the document, for the names of its format.
        path: where the value stands, or would stand.
    """
    if choices := choices_of(hint):
        return " or ".join(choices) if len(choices) == 2 else f"one of {', '.join(choices)}"
    if get_origin(hint) is tuple:
        return _described_tuple(hint, source, path)
    if hint is bool:
        return "true or false"
    return f"a {_WORDS[hint]}" if hint in _WORDS else source.one_table(path)


def _described_tuple(hint: Any, source: Source, path: KeyPath) -> str:
    inner, length = elements_of(hint)
    if length is not None:
        return f"{_COUNTS.get(length, length)} {_WORDS[inner]}s"
    if inner in _WORDS:
        return f"a list of {_WORDS[inner]}s"
    if is_fixed_tuple(inner):
        return f"a list of {described(inner, source, path)}, or several of them"
    if get_origin(inner) is tuple:
        return "a list of lists"
    return source.many_tables(path)


def _kind_of(arm: Any) -> str:
    """A class's name in kebab case: `SecondSender` is `second-sender`."""
    return re.sub(r"(?<!^)(?=[A-Z])", "-", arm.__name__).lower()
