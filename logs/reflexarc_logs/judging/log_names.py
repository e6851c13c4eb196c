"""What logs are called in a report: so that it says the same wherever they lie."""

import os
from collections.abc import Iterable
from pathlib import Path


def named(paths: Iterable[Path]) -> dict[str, Path]:
    """Logs by their names, sorted: the paths below the folder that they have in common.

    Args:
        paths: of the logs; one that is there twice is one.
    """
    whole = {os.path.abspath(path): path for path in paths}
    common = os.path.commonpath([os.path.dirname(place) for place in whole]) if whole else ""
    found = {os.path.relpath(place, common): path for place, path in whole.items()}
    return {name: found[name] for name in sorted(found)}


def without_place(text: str, path: Path) -> str:
    """An error's text that begins with the place of its log, without it."""
    for place in (f"{path}: ", str(path)):
        text = text.removeprefix(place)
    return text.replace(str(path), path.name)
