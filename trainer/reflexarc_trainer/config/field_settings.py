"""Fields of a training configuration, set by their dotted names: `learner.gamma = 0.8`.

The dataclasses say which fields there are and of which type, and check the values themselves.
"""

import dataclasses
import difflib
from collections.abc import Iterator, Mapping
from types import NoneType
from typing import Any, get_args, get_origin

from reflexarc_runtime.config.annotations import fields_of
from reflexarc_runtime.config.fill import converted
from reflexarc_runtime.config.source import MappingSource
from reflexarc_runtime.errors import ReflexarcError, UsageError
from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.config.training_world import parse_training_world

WORLDS, BODY = "worlds", "body"

_NONE = "none"
"""Stands for None, which TOML does not have, where a field takes it."""
_MOST_NEAREST = 3


def with_settings(config: TrainConfig, settings: Mapping[str, object]) -> TrainConfig:
    """A configuration with some of its fields set.

    All fields are set at once: their order does not matter, and what they refuse is about the
    whole. What is not said of a body is as in the world that the policy is meant for.

    Args:
        config: what is changed.
        settings: values as a TOML file has them, by dotted name.

    Raises:
        ReflexarcError: no such field, or a value that it refuses; begins with the field's name.
    """
    changes: dict[str, Any] = {}
    for name, value in settings.items():
        _put(changes, name.split("."), converted_setting(name, value))
    if BODY in changes and config.body is None:
        meant_for = dataclasses.replace(config, worlds=changes.get(WORLDS, config.worlds))
        config = dataclasses.replace(config, body=meant_for.contract().body)
    try:
        changed: TrainConfig = _changed(config, changes)
    except ReflexarcError as error:
        raise UsageError(_with_whole_name(str(error), settings)) from None
    return changed


def converted_setting(name: str, value: object) -> object:
    """A value of a TOML file as the field of that dotted name takes it.

    Raises:
        ReflexarcError: no such field, or a value of another type; begins with the field's name.
    """
    if name == WORLDS:
        return _worlds(value)
    hint = _hint(name)
    if value == _NONE and NoneType in get_args(hint):
        return None
    if get_origin(hint) is tuple and not isinstance(value, list):
        value = [value]  # one stands for a list of one
    return converted(hint, value, MappingSource({}), tuple(name.split(".")))


def as_text(name: str, value: object) -> str:
    """A value that must be a text.

    Raises:
        UsageError: it is none; begins with the field's name.
    """
    if not isinstance(value, str):
        raise UsageError(f"{name}: expected a text, got {value!r}")
    return value


def _put(changes: dict[str, Any], parts: list[str], value: object) -> None:
    """Set a value in a tree of dictionaries."""
    for part in parts[:-1]:
        changes = changes.setdefault(part, {})
    changes[parts[-1]] = value


def _changed(node: Any, changes: Mapping[str, Any]) -> Any:
    """A dataclass with some fields changed, those of the dataclasses within it first."""
    values = {
        name: _changed(getattr(node, name), change) if isinstance(change, dict) else change
        for name, change in changes.items()
    }
    return dataclasses.replace(node, **values)


def _with_whole_name(complaint: str, settings: Mapping[str, object]) -> str:
    """A complaint of an inner dataclass, which knows only the last part of a field's name."""
    where, colon, words = complaint.partition(": ")
    for name in settings:
        whole, found, _ = f".{name}.".rpartition(f".{where}.")
        if colon and found:
            return f"{whole}.{where}: {words}".removeprefix(".")
    return complaint


def _hint(name: str) -> Any:
    """Annotation of a field that can be set."""
    parts = name.split(".")
    hint: Any = TrainConfig
    for depth, part in enumerate(parts):
        fields = _fields(hint)
        if part not in fields:
            known = f"; known: {', '.join(fields)}" if fields else ""
            where = ".".join(parts[: depth + 1])
            raise UsageError(f"{where}: no such field{_nearest(name)}{known}")
        hint = fields[part]
    if fields := _fields(hint):
        raise UsageError(f"{name}: expected one of its fields: {', '.join(fields)}")
    return hint


def _nearest(name: str) -> str:
    """Names of fields that were perhaps meant: those whose last word is the same, or alike."""
    names = list(_leaves(TrainConfig, ""))
    lasts = [known.rpartition(".")[2] for known in names]
    last = name.rpartition(".")[2]
    alike = [last] if last in lasts else difflib.get_close_matches(last, lasts, _MOST_NEAREST)
    found = [known for known, end in zip(names, lasts, strict=True) if end in alike]
    found.sort(key=lambda known: -difflib.SequenceMatcher(None, known, name).ratio())
    return f"; nearest: {', '.join(found[:_MOST_NEAREST])}" if found else ""


def _leaves(kind: Any, prefix: str) -> Iterator[str]:
    """Dotted names of all fields that hold a value."""
    for name, hint in _fields(kind).items():
        if _fields(hint):
            yield from _leaves(hint, f"{prefix}{name}.")
        else:
            yield prefix + name


def _fields(kind: Any) -> Mapping[str, Any]:
    """Annotations of a dataclass's fields, also of one that may be None; none of anything else."""
    arms = [arm for arm in get_args(kind) if arm is not NoneType]
    if len(arms) == 1 and NoneType in get_args(kind):
        kind = arms[0]
    if not (isinstance(kind, type) and dataclasses.is_dataclass(kind)):
        return {}
    return {name: hint for name, (hint, _) in fields_of(kind).items()}


def _worlds(value: object) -> tuple[object, ...]:
    """One NAME or NAME:SHARE, or a list of them, as `reflexarc train --worlds` takes them."""
    names = value if isinstance(value, list) else [value]
    return tuple(_world(as_text(WORLDS, name)) for name in names)


def _world(words: str) -> object:
    try:
        return parse_training_world(words)
    except ReflexarcError as error:
        said = str(error)
        raise UsageError(said if said.startswith(WORLDS) else f"{WORLDS}: {said}") from None
