"""Logs that were made to harm, given to every command that reads logs."""

from collections.abc import Callable
from pathlib import Path

from hostile.measured import Maker
from support import hostile_logs

COMMANDS = [["info", "FILE"], ["recover", "FILE", "-o", "OUT.mcap"], ["replay", "FILE"]]


def _of_bytes(make: Callable[[], bytes]) -> Maker:
    return _of_file(lambda path: path.write_bytes(make()))


def _of_file(write: Callable[[Path], object]) -> Maker:
    def maker(folder: Path) -> tuple[Path, list[list[str]]]:
        path = folder / "hostile.mcap"
        write(path)
        return path, COMMANDS

    return maker


FILES: dict[str, Maker] = {
    **{name: _of_bytes(make) for name, make in hostile_logs.BYTES.items()},
    **{name: _of_file(write) for name, write in hostile_logs.FILES.items()},
}
