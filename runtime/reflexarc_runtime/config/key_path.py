"""Where a value stands in a document: the keys and indices that lead to it from the top."""

import re
from typing import TypeAlias

KeyPath: TypeAlias = tuple[str | int, ...]
"""Keys and indices from the top of a document down to a value; () is the document."""

_BARE = re.compile(r"[A-Za-z0-9_-]{1,64}")
_LONGEST_QUOTED = 40
"""Characters of an unusual key that a message shows."""


def dotted(path: KeyPath) -> str:
    """A path as one reads it: `layers[0].density_per_m2`."""
    parts = [f"[{part}]" if isinstance(part, int) else f".{_shown(part)}" for part in path]
    return "".join(parts).removeprefix(".")


def without_indices(path: KeyPath) -> str:
    """A path as a TOML header writes it: `layers.shapes` for the tables of any layer."""
    return dotted(tuple(part for part in path if isinstance(part, str)))


def _shown(key: str) -> str:
    return key if _BARE.fullmatch(key) else repr(key[:_LONGEST_QUOTED])
