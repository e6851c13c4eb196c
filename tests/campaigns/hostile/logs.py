"""Logs that were made to harm."""

from pathlib import Path

from hostile.measured import Maker


def _empty(folder: Path) -> tuple[Path, list[list[str]]]:
    path = folder / "empty.mcap"
    path.write_bytes(b"")
    return path, [["info", "FILE"], ["recover", "FILE", "-o", "OUT.mcap"], ["replay", "FILE"]]


FILES: dict[str, Maker] = {"an empty log": _empty}
