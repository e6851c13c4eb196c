"""The flags of a command as one flat list, as a file of settings names them."""

import dataclasses
from collections.abc import Iterator
from typing import Any, get_type_hints

NOT_IN_FILES = ("config", "show_config")


@dataclasses.dataclass(frozen=True)
class CommandField:
    """One flag."""

    name: str
    """As Python writes it: `rotate_s`; the command line has `--rotate-s`."""
    hint: Any
    """Annotation of its value."""
    default: Any
    """`dataclasses.MISSING` where it has to be given."""


def fields_of_command(kind: type) -> Iterator[CommandField]:
    """All flags, those of the groups within it included, in the order in which help shows them."""
    hints = get_type_hints(kind)
    for each in dataclasses.fields(kind):
        hint = hints[each.name]
        if each.name in NOT_IN_FILES:
            continue
        if dataclasses.is_dataclass(hint):
            yield from fields_of_command(hint)  # type: ignore[arg-type]  # a class, not an instance
        else:
            yield CommandField(each.name, hint, _default_of(each))


def values_of_command(command: Any) -> Iterator[tuple[str, Any]]:
    """The value of each flag of a command, under its name."""
    for each in dataclasses.fields(command):
        value = getattr(command, each.name)
        if each.name in NOT_IN_FILES:
            continue
        if dataclasses.is_dataclass(value):
            yield from values_of_command(value)
        else:
            yield each.name, value


def _default_of(each: "dataclasses.Field[Any]") -> Any:
    if each.default_factory is not dataclasses.MISSING:
        return each.default_factory()
    return each.default
