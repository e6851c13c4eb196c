"""Wherever a public function takes a path, it takes its name as well."""

import inspect
import typing
from collections.abc import Callable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

FACADES = ("reflexarc", "reflexarc_logs", "reflexarc_sim_bridge")
"""Packages that name what is public in them."""
OTHERS = (
    "reflexarc_logs.reading.recover:recover",
    "reflexarc_logs.cutting.cut:cut",
    "reflexarc_logs.importing.lidar_import:import_log",
    "reflexarc_pictures.rendering:render_log",
    "reflexarc_pictures.rendering:render_world",
    "reflexarc_pictures.rendering:render_results",
    "reflexarc_runtime.policy.policy:load_contract",
)
"""Further functions that documents tell to call."""


def public() -> Iterator[tuple[str, Callable[..., Any]]]:
    for name in FACADES:
        package = import_module(name)
        yield from ((f"{name}.{each}", getattr(package, each)) for each in package.__all__)
    for place in OTHERS:
        module, _, name = place.partition(":")
        yield place, getattr(import_module(module), name)


def paths_of(function: Callable[..., Any]) -> dict[str, list[object]]:
    """The parameters that may be a path: all that each may be."""
    try:
        hints = typing.get_type_hints(function)
    except NameError:  # of what is imported for the type checker alone
        hints = {name: str(hint) for name, hint in inspect.get_annotations(function).items()}
    kinds = {name: [*typing.get_args(hint)] or [hint] for name, hint in hints.items()}
    return {name: kind for name, kind in kinds.items() if Path in kind and name != "return"}


FUNCTIONS = {name: each for name, each in public() if inspect.isfunction(each)}
"""Classes apart: those that hold a path are results."""


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_path_may_be_given_by_its_name(name: str):
    for parameter, kinds in paths_of(FUNCTIONS[name]).items():
        assert str in kinds, f"{name}: {parameter} takes a Path only"


def test_paths_are_found():
    assert {*paths_of(FUNCTIONS["reflexarc.train"])} == {"out", "init_from"}
    assert {*paths_of(FUNCTIONS["reflexarc_logs.reading.recover:recover"])} == {"path", "out"}
