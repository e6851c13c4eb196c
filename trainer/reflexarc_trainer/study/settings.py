"""The settings of a study's cell: fields of the configuration, a preset, where it is measured."""

from collections.abc import Mapping

from reflexarc_runtime.errors import ReflexarcError, UsageError
from reflexarc_trainer.config.field_settings import as_text, converted_setting, with_settings
from reflexarc_trainer.config.presets import preset_named
from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.config.training_world import TrainingWorld

PRESET = "preset"
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

    Args:
        preset: name of the preset.
        settings: values as a TOML file has them, by dotted name.

    Raises:
        ReflexarcError: no such field, or a value that it refuses; begins with the field's name.
    """
    fields = {name: settings[name] for name in settings if name not in (PRESET, MEASURED_IN)}
    for name in fields:
        _require_here(name)
    if PRESET in settings:
        preset = as_text(PRESET, settings[PRESET])
    return with_settings(preset_named(preset), fields)


def check_setting(name: str, value: object) -> None:
    """Refuse a field that there is not, or a value of another type.

    Raises:
        ReflexarcError: it is one; begins with the field's name.
    """
    if name == PRESET:
        preset_named(as_text(name, value))
    elif name == MEASURED_IN:
        measured_in({name: value})
    else:
        _require_here(name)
        converted_setting(name, value)


def measured_in(settings: Mapping[str, object]) -> str:
    """The world that settings name for the measurement; "" where they name none.

    Raises:
        ReflexarcError: there is no such world; begins with the field's name.
    """
    if MEASURED_IN not in settings:
        return ""
    name = as_text(MEASURED_IN, settings[MEASURED_IN])
    try:
        return TrainingWorld(name).name
    except ReflexarcError as error:
        raise UsageError(f"{MEASURED_IN}: {error}") from None


def _require_here(name: str) -> None:
    if instead := _NOT_HERE.get(name.partition(".")[0]):
        raise UsageError(f"{name}: cannot be set in a cell; use {instead}")
