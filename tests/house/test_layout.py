"""The house from outside: a newcomer finds the room from the listing."""

import ast
import tomllib
from collections import Counter, defaultdict
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ROOMS = {
    path.parent.name: path
    for path in (
        ROOT / "cli" / "reflexarc",
        *sorted(ROOT.glob("*/reflexarc_*")),
    )
    if (path / "__init__.py").exists()
}
MOST_FILES = 20

PARALLEL_FOLDERS = {
    "sim_bridge": (
        {"body", "body/camera", "body/ros2"},  # a body on our bus, each with its bridge
        {"worlds/kinds", "obstacles/kinds"},  # both halves of a kind of layer
    ),
    "trainer": ({"sarsa/online", "sarsa/batched"},),  # two compiled forms of one algorithm
}
"""Counterparts in these folders share their file names."""


def sources(room: Path) -> list[Path]:
    return [path for path in sorted(room.rglob("*.py")) if not path.name.endswith("_pb2.py")]


def all_sources() -> Iterator[Path]:
    for room in ROOMS.values():
        yield from sources(room)


def test_all_rooms_are_looked_at() -> None:
    assert set(ROOMS) == {
        "baselines",
        "cli",
        "logs",
        "pictures",
        "runtime",
        "sim_bridge",
        "trainer",
    }


def test_the_wheel_brings_every_room_and_every_check_looks_at_it() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]
    packed = settings["hatch"]["build"]["targets"]["wheel"]["packages"]
    assert {ROOT / path for path in packed} == set(ROOMS.values())
    names = {path.name for path in ROOMS.values()}
    assert set(settings["mypy"]["packages"]) == names
    assert set(settings["importlinter"]["root_packages"]) == names


@pytest.mark.parametrize("room", sorted(ROOMS))
def test_every_package_says_that_it_is_typed(room: str) -> None:
    assert (ROOMS[room] / "py.typed").exists()


def test_no_folder_has_more_files_than_a_reader_takes_in_at_a_glance() -> None:
    counts = Counter(path.parent for path in all_sources())
    assert {str(folder): n for folder, n in counts.items() if n > MOST_FILES} == {}


def test_every_folder_says_in_its_first_line_what_it_is_for() -> None:
    for folder in {path.parent for path in all_sources()}:
        docstring = ast.get_docstring(ast.parse((folder / "__init__.py").read_text()))
        assert docstring, f"{folder}: expected a docstring in __init__.py"
        assert docstring.splitlines()[0].endswith("."), folder


@pytest.mark.parametrize("room", sorted(ROOMS))
def test_no_file_name_stands_twice_within_a_room_but_for_counterparts(room: str) -> None:
    folders: dict[str, list[str]] = defaultdict(list)
    for path in sources(ROOMS[room]):
        if not path.name.startswith("__"):
            folders[path.name].append(str(path.parent.relative_to(ROOMS[room])))
    twice = {name: set(where) for name, where in folders.items() if len(where) > 1}
    parallel = PARALLEL_FOLDERS.get(room, ())
    assert {name for name, where in twice.items() if not any(where <= p for p in parallel)} == set()


def test_no_class_name_means_two_things() -> None:
    found = defaultdict(list)
    for path in all_sources():
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
                found[node.name].append(str(path.relative_to(ROOT)))
    assert {name: paths for name, paths in found.items() if len(paths) > 1} == {}


def test_no_private_name_is_used_in_another_file() -> None:
    used = []
    for path in all_sources():
        tree = ast.parse(path.read_text())
        modules = set()
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("reflexarc"):
                used += [(path.name, a.name) for a in node.names if is_private(a.name)]
                modules |= {alias.asname or alias.name for alias in node.names}
        for node in ast.walk(tree):
            if isinstance(node, ast.Attribute) and is_private(node.attr):
                owner = node.value
                if isinstance(owner, ast.Name) and owner.id in modules and owner.id.islower():
                    used.append((path.name, f"{owner.id}.{node.attr}"))
    assert used == []


def is_private(name: str) -> bool:
    return name.startswith("_") and not name.startswith("__")


def test_tests_lie_where_what_they_test_lies() -> None:
    """A test of a module stands in the folder of the same name; the others in any of the room's."""
    for room, package in ROOMS.items():
        modules = {path.stem: path.parent.relative_to(package) for path in sources(package)}
        folders = {path.parent.relative_to(package) for path in sources(package)}
        for test in (ROOT / "tests" / room).rglob("test_*.py"):
            folder = test.parent.relative_to(ROOT / "tests" / room)
            assert folder in folders, f"{test}: expected a folder of {package}"
            names = Counter(path.stem for path in sources(package))
            name = test.stem.removeprefix("test_")
            if names[name] == 1:
                assert folder == modules[name], f"{test}: expected in {modules[name]}"
