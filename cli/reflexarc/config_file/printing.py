"""Prints a command with all its settings as the TOML file that would give the same."""

import json
from collections.abc import Iterator
from enum import Enum
from pathlib import Path
from typing import Any

from reflexarc.config_file.command_fields import values_of_command


def as_toml(command: Any) -> str:
    """All settings of a command; what is not set stands in a comment."""
    return "".join(f"{line}\n" for line in _lines(command))


def _lines(command: Any) -> Iterator[str]:
    for name, value in values_of_command(command):
        key = name.replace("_", "-")
        yield f"# {key} =" if value is None else f"{key} = {_as_value(value)}"


def _as_value(value: Any) -> str:
    if isinstance(value, Enum):
        return json.dumps(value.value)
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, Path):
        return json.dumps(str(value.absolute()), ensure_ascii=False)
    if isinstance(value, tuple | list):
        return f"[{', '.join(map(_as_value, value))}]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    return repr(value)
