"""Keeps what took long to compute and depends on nothing but code and plain values.

What the shipped suites need of a point ships with the package (`shipped.json`,
written by `make limits`), by a hash over all that it depends on and the version of the generator of
obstacles; a test computes some of it anew. Everything else is kept on disk.

A file there lies in the folder of compiled code, which is named after a hash of all sources of
worlds, obstacles and contacts: when one of them changes, nothing is found any more. Its name is a
hash over the sources of the limits and over all that the figures depend on, each number in full. It
is whole or absent. Where no folder can be written, everything is computed anew, and right.
"""

import contextlib
import hashlib
import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from reflexarc_runtime.files import write_atomically
from reflexarc_sim_bridge.native.cache import cache_folder, source_key
from reflexarc_sim_bridge.obstacles.keys import GENERATOR_VERSION

SHIPPED = Path(__file__).parent / "shipped.json"
_KEY_DIGITS = 24
_COMPUTED_FROM = (
    "reflexarc_sim_bridge/evaluation/limits",
    "reflexarc_sim_bridge/evaluation/protocol/setting.py",
)


def kept(depends_on: Any, compute: Callable[[], list[float]]) -> list[float]:
    """Figures from disk, or computed now and kept.

    Args:
        depends_on: plain values whose `repr` tells all of them: numbers, texts, tuples, lists, and
            dataclasses of these.
        compute: the figures; finite ones.
    """
    shipped = shipped_figures().get(shipped_key(depends_on))
    if shipped is not None:
        return list(shipped)
    path = _path(depends_on)
    found = None if path is None else _read(path)
    if found is not None:
        return found
    figures = compute()
    if path is not None:
        with contextlib.suppress(OSError):  # a full disk is no reason to fail
            write_atomically(path, json.dumps(figures).encode())
    return figures


def shipped_key(depends_on: Any) -> str:
    """The name under which figures ship; another one as soon as anything about a world differs."""
    text = f"{GENERATOR_VERSION} {depends_on!r}"
    return hashlib.sha256(text.encode()).hexdigest()[:_KEY_DIGITS]


@cache
def shipped_figures() -> dict[str, list[float]]:
    """All that ships, by its key; nothing if the file is missing."""
    try:
        found: dict[str, list[float]] = json.loads(SHIPPED.read_bytes())
    except OSError:
        return {}
    return found


def _path(depends_on: Any) -> Path | None:
    folder = cache_folder()
    if folder is None:
        return None
    text = f"{source_key(_COMPUTED_FROM)} {depends_on!r}"
    return folder / "limits" / f"{hashlib.sha256(text.encode()).hexdigest()}.json"


def _read(path: Path) -> list[float] | None:
    """The figures of a file; None where there is none, or none that is sound."""
    try:
        figures = json.loads(path.read_bytes())
    except (OSError, ValueError):
        return None
    is_sound = isinstance(figures, list) and all(isinstance(one, float) for one in figures)
    return figures if is_sound else None
