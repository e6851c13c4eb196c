"""Policies that were made to harm, each given to the commands that load one."""

from collections.abc import Callable
from pathlib import Path

from hostile.measured import Maker
from support.hostile_policies import POLICIES

_COMMANDS = [
    ["info", "FILE"],
    ["run", "FILE", "--ticks", "1", "--port", "7999"],
    ["run", "FILE", "--ticks", "1", "--port", "7999", "--backend", "onnxruntime"],
    ["evaluate", "FILE", "--agents", "16", "--steps", "20"],
]


def _maker(make: Callable[[], bytes]) -> Maker:
    def written(folder: Path) -> tuple[Path, list[list[str]]]:
        path = folder / "policy.onnx"
        path.write_bytes(make())
        return path, _COMMANDS

    return written


FILES: dict[str, Maker] = {name: _maker(make) for name, make in POLICIES.items()}
