"""The arrows between and inside the rooms hold, and the check of each can fail."""

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[2]
ROOMS = ("baselines", "cli", "logs", "pictures", "runtime", "sim_bridge", "trainer")
LINT = Path(sys.executable).with_name("lint-imports")


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """The rooms in a place where they can be spoiled."""
    for room in ROOMS:
        [package] = [p for p in (ROOT / room).glob("reflexarc*") if (p / "__init__.py").exists()]
        shutil.copytree(package, tmp_path / room / package.name)
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    return tmp_path


def broken(folder: Path) -> tuple[set[str], set[str]]:
    """Names of the contracts that do not hold, and of those that do."""
    paths = os.pathsep.join(str(folder / room) for room in ROOMS)
    done = subprocess.run(
        [str(LINT), "--no-cache"],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": paths, "COLUMNS": "400"},
        capture_output=True,
        text=True,
    )
    verdicts = re.findall(r"^(.*?) (KEPT|BROKEN)\b", done.stdout, re.MULTILINE)
    assert verdicts, done.stdout + done.stderr
    return (
        {name for name, verdict in verdicts if verdict == "BROKEN"},
        {name for name, verdict in verdicts if verdict == "KEPT"},
    )


def contracts() -> list[dict[str, Any]]:
    document = tomllib.loads((ROOT / "pyproject.toml").read_text())
    found: list[dict[str, Any]] = document["tool"]["importlinter"]["contracts"]
    return found


def test_every_contract_breaks_when_it_is_broken(copy: Path) -> None:
    """One import against each of them at once: all of them must notice."""
    for contract in contracts():
        importer, imported = offence(contract)
        module = source_of(copy, importer)
        module.write_text(module.read_text() + f"\nimport {imported}  # against the contract\n")
    offended, held = broken(copy)
    assert offended == {contract["name"] for contract in contracts()}
    assert held == set()


def test_a_module_that_no_layer_names_is_noticed(copy: Path) -> None:
    inside = [c for c in contracts() if c.get("exhaustive")]
    for contract in inside:
        [container] = contract["containers"]
        (source_of(copy, container).parent / "newcomer.py").write_text('"""Nowhere yet."""\n')
    assert {contract["name"] for contract in inside} <= broken(copy)[0]


def offence(contract: dict[str, Any]) -> tuple[str, str]:
    """An import that a contract forbids: who, and what."""
    if contract["type"] == "forbidden":
        return contract["source_modules"][-1], contract["forbidden_modules"][0]
    lowest, highest = first_of(contract["layers"][-1]), first_of(contract["layers"][0])
    container = contract.get("containers", [""])[0]
    prefix = f"{container}." if container else ""
    return f"{prefix}{lowest}", f"{prefix}{highest}"


def first_of(layer: str) -> str:
    return re.split(r"[|:]", layer)[0].strip(" ()")


def source_of(copy: Path, module: str) -> Path:
    """The file of a module, or of a package's `__init__`."""
    [start] = [
        path
        for room in ROOMS
        for path in (copy / room).glob(module.partition(".")[0])
        if path.is_dir()
    ]
    place = start.joinpath(*module.split(".")[1:])
    return place / "__init__.py" if place.is_dir() else place.with_suffix(".py")
