"""Settings as one line of JSON, as a log's metadata holds them."""

import dataclasses
import json
from collections.abc import Mapping
from typing import Any, TypeVar

from reflexarc_runtime.config.fill import fill
from reflexarc_runtime.config.source import MappingSource
from reflexarc_runtime.errors import LogError

_T = TypeVar("_T")


def in_one_line(settings: Any) -> str:
    """A dataclass as one line."""
    return json.dumps(dataclasses.asdict(settings), sort_keys=True)


def from_one_line(kind: type[_T], text: str, name: str, added: Mapping[str, object]) -> _T:
    """Read it back.

    Args:
        kind: the dataclass.
        text: what `in_one_line` wrote.
        name: what a complaint calls it.
        added: what older lines mean where they lack a field.

    Raises:
        LogError: it is not what `in_one_line` wrote.
    """
    try:
        document = json.loads(text)
    except (ValueError, RecursionError):
        document = None
    if not isinstance(document, dict):
        raise LogError(f"{name}: got {text[:40]!r}; the log is damaged")
    source = MappingSource({**added, **document}, name, LogError)
    return fill(kind, source, require_all=True)
