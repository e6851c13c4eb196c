"""The axes of a study: what it varies, as tables of its TOML file.

[[axis]]
label = "hidden units"
field = "network.hidden"           # any field of the configuration, by its dotted name
values = [5, 10, 20]
scale = "log"                      # of the figure's axis; by default linear

[[axis]]                           # values that set several fields
label = "learner"

[[axis.choice]]
name = "the field's eye"
preset = "online"

[[axis.choice]]
name = "a short range"
"retina.range_m" = 0.8
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

from reflexarc_runtime.config.checks import require
from reflexarc_runtime.config.key_path import KeyPath
from reflexarc_runtime.config.toml_source import TomlSource
from reflexarc_runtime.errors import ReflexarcError, UsageError
from reflexarc_trainer.study.settings import check_setting

_LONGEST_LABEL = 80


class AxisScale(StrEnum):
    """The scale of a figure's axis."""

    LINEAR = "linear"
    LOG = "log"


@dataclass(frozen=True)
class Choice:
    """One value of an axis, or one cell of a list: its name, and the fields that it sets."""

    name: str
    settings: Mapping[str, object]
    """Values of fields, by their dotted names."""
    path: KeyPath
    """Its place in the file, for error messages."""
    paths: Mapping[str, KeyPath]
    """The place of each setting."""
    number: float | None = None
    """The value, if it is a number."""


@dataclass(frozen=True)
class Axis:
    """A quantity that the study varies, with its values."""

    label: str
    choices: tuple[Choice, ...]
    scale: AxisScale = AxisScale.LINEAR

    @property
    def is_numeric(self) -> bool:
        """Whether it has several values, all of them numbers: a figure can draw lines over them."""
        return len(self.choices) > 1 and all(c.number is not None for c in self.choices)


@dataclass(frozen=True)
class AxisTable:
    """The table of an axis, as the file has it."""

    label: str
    field: str = ""
    values: object = ()
    choice: tuple[object, ...] = ()
    scale: AxisScale = AxisScale.LINEAR

    def __post_init__(self) -> None:
        require_words("label", self.label)
        by_field, lists = bool(self.field), isinstance(self.values, list) and bool(self.values)
        require(by_field == lists, "values", "a list of values, together with `field`", self.values)
        require(by_field != bool(self.choice), "field", "either field and values, or choices", "")


def read_axes(
    source: TomlSource, tables: Sequence[AxisTable], cells: Sequence[object]
) -> Iterator[Axis]:
    """The axes of a study. A list of cells becomes a single axis.

    Args:
        source: the file, for error messages.
        tables: its tables of axes.
        cells: its tables of cells.

    Raises:
        ReflexarcError: a field does not exist or does not take the value; with the line.
    """
    if cells:
        yield Axis("cell", tuple(_choices(source, cells, ("cell",))))
    for n, table in enumerate(tables):
        path: KeyPath = ("axis", n)
        if table.choice:
            choices = tuple(_choices(source, table.choice, (*path, "choice")))
        else:
            choices = tuple(_values(source, table, path))
        _check_names(source, choices)
        _check_scale(source, table.scale, choices)
        yield Axis(table.label, choices, table.scale)


def require_words(where: str, words: str) -> None:
    """Check that a name can be printed in a cell of a Markdown table and in a figure.

    Raises:
        UsageError: it is too long, or has characters that cannot be printed there.
    """
    fits = words.isprintable() and 1 <= len(words) <= _LONGEST_LABEL and not set("|$") & set(words)
    wanted = f"1 to {_LONGEST_LABEL} printable characters without | and $"
    require(fits, where, wanted, repr(words[: _LONGEST_LABEL + 1]))


def _values(source: TomlSource, axis: AxisTable, path: KeyPath) -> Iterator[Choice]:
    """A choice for each value of an axis of one field."""
    assert isinstance(axis.values, list)  # checked on construction
    for n, value in enumerate(axis.values):
        at = (*path, "values", n)
        number = float(value) if type(value) in (int, float) else None
        choice = Choice(_shown(value), {axis.field: value}, at, {axis.field: at}, number)
        _check_choice(source, choice)
        yield choice


def _choices(source: TomlSource, tables: Sequence[object], path: KeyPath) -> Iterator[Choice]:
    """A choice for each table: its name, and all other keys as settings."""
    for n, table in enumerate(tables):
        at = (*path, n)
        if not isinstance(table, dict) or not isinstance(table.get("name"), str):
            raise source.complaint((*at, "name"), "expected a table with a name")
        name, paths = table["name"], dict[str, KeyPath]()
        try:
            require_words("name", name)
        except UsageError as error:
            raise source.complaint(at, str(error)) from None
        settings = dict(_flat({k: v for k, v in table.items() if k != "name"}, at, "", paths))
        choice = Choice(name, settings, at, paths)
        _check_choice(source, choice)
        yield choice


def _flat(
    table: Mapping[str, object], at: KeyPath, prefix: str, paths: dict[str, KeyPath]
) -> Iterator[tuple[str, object]]:
    """The values of a table by dotted names; fills in the place of each."""
    for key, value in table.items():
        name, here = prefix + key, (*at, key)
        if isinstance(value, dict):
            yield from _flat(value, here, f"{name}.", paths)
        else:
            paths[name] = here
            yield name, value


def _check_choice(source: TomlSource, choice: Choice) -> None:
    """Check that all fields exist and take values of this type."""
    for name, value in choice.settings.items():
        try:
            check_setting(name, value)
        except ReflexarcError as error:
            raise source.complaint(choice.path, str(error)) from None


def _check_names(source: TomlSource, choices: tuple[Choice, ...]) -> None:
    seen = set[str]()
    for choice in choices:
        if choice.name in seen:
            raise source.complaint(choice.path, f"expected different values, got {choice.name!r}")
        seen.add(choice.name)


def _check_scale(source: TomlSource, scale: AxisScale, choices: tuple[Choice, ...]) -> None:
    """Check that an axis with a logarithmic scale has positive numbers only."""
    for choice in choices:
        if scale is AxisScale.LOG and not (choice.number is not None and choice.number > 0.0):
            words = f"expected a number above 0, for scale = 'log', got {choice.name}"
            raise source.complaint(choice.path, words)


def _shown(value: object) -> str:
    """A value as a name."""
    if isinstance(value, list):
        return "–".join(map(_shown, value))
    return f"{value:g}" if isinstance(value, float) else str(value)
