"""What a study varies: axes and their values, and what each value sets.

[[axis]]
label = "hidden units"
field = "network.hidden"           # any field of the configuration, by its dotted name
values = [5, 10, 20]
scale = "log"                      # of the picture; by default linear

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
    """How an axis of numbers is drawn."""

    LINEAR = "linear"
    LOG = "log"


@dataclass(frozen=True)
class Choice:
    """One value of an axis, or a cell of a list: its name and what it sets."""

    name: str
    settings: Mapping[str, object]
    """Values by dotted field names."""
    path: KeyPath
    """Where it stands in the file."""
    paths: Mapping[str, KeyPath]
    """Where each setting stands."""
    number: float | None = None
    """The value, on an axis of numbers."""


@dataclass(frozen=True)
class Axis:
    """Something that is varied."""

    label: str
    choices: tuple[Choice, ...]
    scale: AxisScale = AxisScale.LINEAR

    @property
    def is_numeric(self) -> bool:
        """Whether its values are numbers that a line can be drawn over."""
        return len(self.choices) > 1 and all(c.number is not None for c in self.choices)


@dataclass(frozen=True)
class AxisTable:
    """An axis as a file has it."""

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
    """The axes of a study; a list of cells is one.

    Args:
        source: the file, for complaints.
        tables: its axes.
        cells: its cells.

    Raises:
        ReflexarcError: of the source's class: something that no field takes, with its line.
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
    """Refuse what does not fit into a cell of a table, or onto a picture.

    Raises:
        UsageError: it does not.
    """
    fits = words.isprintable() and 1 <= len(words) <= _LONGEST_LABEL and not set("|$") & set(words)
    wanted = f"1 to {_LONGEST_LABEL} printable characters without | and $"
    require(fits, where, wanted, repr(words[: _LONGEST_LABEL + 1]))


def _values(source: TomlSource, axis: AxisTable, path: KeyPath) -> Iterator[Choice]:
    """A choice for each value of one field."""
    assert isinstance(axis.values, list)  # checked on construction
    for n, value in enumerate(axis.values):
        at = (*path, "values", n)
        number = float(value) if type(value) in (int, float) else None
        choice = Choice(_shown(value), {axis.field: value}, at, {axis.field: at}, number)
        _check_choice(source, choice)
        yield choice


def _choices(source: TomlSource, tables: Sequence[object], path: KeyPath) -> Iterator[Choice]:
    """A choice for each table: its name, and all else what it sets."""
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
    """Values by dotted names, quoted or nested; notes where each stands."""
    for key, value in table.items():
        name, here = prefix + key, (*at, key)
        if isinstance(value, dict):
            yield from _flat(value, here, f"{name}.", paths)
        else:
            paths[name] = here
            yield name, value


def _check_choice(source: TomlSource, choice: Choice) -> None:
    """Refuse fields that there are not, and values of a wrong type."""
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
    """Only numbers above zero have a logarithm."""
    for choice in choices:
        if scale is AxisScale.LOG and not (choice.number is not None and choice.number > 0.0):
            words = f"expected a number above 0, for scale = 'log', got {choice.name}"
            raise source.complaint(choice.path, words)


def _shown(value: object) -> str:
    """A value as a name."""
    if isinstance(value, list):
        return "–".join(map(_shown, value))
    return f"{value:g}" if isinstance(value, float) else str(value)
