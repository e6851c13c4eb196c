"""Fault scripts as files: TOML, read strictly.

seed = 17                 # of every draw
repeat_s = 5.0            # begin again after so long; 0 or absent: once

[[fault]]
kind = "delay"            # one of KINDS
begin_s = 1.0
duration_s = 0.5
delay_s = 0.3             # the kind's own fields
"""

import dataclasses
import tomllib
from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path
from typing import Any

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.fault_script import KINDS, Fault, FaultScript


def read_script(path: Path) -> FaultScript:
    """Read a script from a TOML file.

    Raises:
        UsageError: the file cannot be read, or says what no script can say.
    """
    try:
        return parse_script(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UsageError(
            f"--faults: {path}: cannot be read: {error.strerror}; give a TOML file or seed:N"
        ) from None
    except UnicodeDecodeError:
        raise UsageError(f"--faults: {path}: expected TOML, got no text") from None
    except UsageError as error:
        raise UsageError(f"--faults: {path}: {error}") from None


def parse_script(text: str) -> FaultScript:
    """Read a script from TOML text.

    Raises:
        UsageError: no TOML; a field is missing, unknown, of the wrong type or out of range.
    """
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise UsageError(f"expected TOML: {' '.join(str(error).split())}") from None
    tables = document.pop("fault", [])
    if not isinstance(tables, list) or not all(isinstance(table, dict) for table in tables):
        raise UsageError("fault: expected tables, each under [[fault]]")
    faults = tuple(_fault(table, f"fault {n}") for n, table in enumerate(tables, start=1))
    script: FaultScript = _filled(FaultScript, {"faults": faults, **document}, "script")
    return script


def _fault(table: dict[str, Any], where: str) -> Fault:
    kind = table.pop("kind", None)
    if not isinstance(kind, str) or kind not in KINDS:
        raise UsageError(f"{where}: kind: expected one of {', '.join(KINDS)}, got {kind!r}")
    fault: Fault = _filled(KINDS[kind], table, f"{where} ({kind})")
    return fault


def _filled(kind: type[Any], table: Mapping[str, Any], where: str) -> Any:
    """A dataclass filled from a table, strictly."""
    fields = {field.name: field for field in dataclasses.fields(kind)}
    for name in table:
        if name not in fields:
            raise UsageError(f"{where}: {name}: unknown; known: {', '.join(fields)}")
    for name, field in fields.items():
        if name not in table and field.default is dataclasses.MISSING:
            raise UsageError(f"{where}: {name}: missing")
    values = {name: _value(fields[name].type, v, f"{where}: {name}") for name, v in table.items()}
    return kind(**values)


def _value(kind: Any, value: object, where: str) -> object:
    if isinstance(kind, type) and issubclass(kind, StrEnum):
        return _choice(kind, value, where)
    numbers = {float: (int, float), int: (int,)}.get(kind)
    if numbers and (isinstance(value, bool) or not isinstance(value, numbers)):
        raise UsageError(f"{where}: expected a number ({kind.__name__}), got {value!r}")
    return value


def _choice(kind: type[StrEnum], value: object, where: str) -> StrEnum:
    try:
        return kind(str(value))
    except ValueError:
        raise UsageError(f"{where}: expected one of {', '.join(kind)}, got {value!r}") from None
