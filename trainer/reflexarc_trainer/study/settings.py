"""Fields of a training configuration, set by their dotted names: `learner.gamma = 0.8`.

The dataclasses say which fields there are and of which type, and check the values themselves.
"""

import dataclasses
from collections.abc import Mapping
from typing import Any, get_origin

from reflexarc_runtime.config.annotations import fields_of
from reflexarc_runtime.config.fill import converted
from reflexarc_runtime.config.source import MappingSource
from reflexarc_runtime.errors import ReflexarcError, UsageError
from reflexarc_trainer.config.presets import preset_named
from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.config.training_world import TrainingWorld, parse_training_world

PRESET, WORLDS = "preset", "worlds"
MEASURED_IN = "measured_in"
"""The world that a cell is measured in, if that is not the one that it learns in last."""

_NOT_HERE = {
    "seed": "`seeds` of the study",
    "validation": "nothing: a study measures at the end, on test worlds",
    "init_from": "nothing: a study's runs begin with new weights",
}
"""What a cell cannot set, and what says it in its place."""


def configured(preset: str, settings: Mapping[str, object]) -> TrainConfig:
    """A preset with some of its fields set; a preset among the settings takes its place.

    All fields are set at once: their order does not matter, and what they refuse is about the
    whole.

    Args:
        preset: name of the preset.
        settings: values as a TOML file has them, by dotted name.

    Raises:
        ReflexarcError: no such field, or a value that it refuses; begins with the field's name.
    """
    changes: dict[str, Any] = {}
    for name, value in settings.items():
        if name == MEASURED_IN:
            continue
        if name == PRESET:
            preset = _text(name, value)
        else:
            _put(changes, name.split("."), _converted(name, value))
    changed: TrainConfig = _changed(preset_named(preset), changes)
    return changed


def check_setting(name: str, value: object) -> None:
    """Refuse a field that there is not, or a value of another type.

    Raises:
        ReflexarcError: it is one; begins with the field's name.
    """
    if name == PRESET:
        preset_named(_text(name, value))
    elif name == MEASURED_IN:
        measured_in({name: value})
    else:
        _converted(name, value)


def measured_in(settings: Mapping[str, object]) -> str:
    """The world that settings name for the measurement; "" where they name none.

    Raises:
        ReflexarcError: there is no such world; begins with the field's name.
    """
    if MEASURED_IN not in settings:
        return ""
    name = _text(MEASURED_IN, settings[MEASURED_IN])
    try:
        return TrainingWorld(name).name
    except ReflexarcError as error:
        raise UsageError(f"{MEASURED_IN}: {error}") from None


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


def _converted(name: str, value: object) -> object:
    """A value of a TOML file as the field takes it."""
    if name == WORLDS:
        return _worlds(value)
    hint = _hint(name)
    if get_origin(hint) is tuple and not isinstance(value, list):
        value = [value]  # one stands for a list of one
    return converted(hint, value, MappingSource({}), tuple(name.split(".")))


def _hint(name: str) -> Any:
    """Annotation of a field that can be set."""
    parts = name.split(".")
    if parts[0] in _NOT_HERE:
        raise UsageError(f"{name}: cannot be set in a cell; use {_NOT_HERE[parts[0]]}")
    hint: Any = TrainConfig
    for depth, part in enumerate(parts):
        fields = _fields(hint)
        if part not in fields:
            known = f"; known: {', '.join(fields)}" if fields else ""
            raise UsageError(f"{'.'.join(parts[: depth + 1])}: no such field{known}")
        hint = fields[part]
    if fields := _fields(hint):
        raise UsageError(f"{name}: expected one of its fields: {', '.join(fields)}")
    return hint


def _fields(kind: Any) -> Mapping[str, Any]:
    """Annotations of a dataclass's fields; none of anything else."""
    if not (isinstance(kind, type) and dataclasses.is_dataclass(kind)):
        return {}
    return {name: hint for name, (hint, _) in fields_of(kind).items()}


def _worlds(value: object) -> tuple[object, ...]:
    """One NAME or NAME:SHARE, or a list of them, as `reflexarc train --worlds` takes them."""
    names = value if isinstance(value, list) else [value]
    return tuple(_world(_text(WORLDS, name)) for name in names)


def _world(words: str) -> object:
    try:
        return parse_training_world(words)
    except ReflexarcError as error:
        said = str(error)
        raise UsageError(said if said.startswith(WORLDS) else f"{WORLDS}: {said}") from None


def _text(name: str, value: object) -> str:
    if not isinstance(value, str):
        raise UsageError(f"{name}: expected a text, got {value!r}")
    return value
