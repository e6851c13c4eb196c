"""The definition of a study: a TOML file.

title = "Size of the hidden layer"
question = "How many hidden units does it take?"
preset = "paper"                   # the configuration that cells change
seeds = 8                          # a number, counted from 0; or a list
steps = 524288                     # by default the preset's
measure = "contacts"               # or share_of_blind, edge_index, suite
asked = "10"                       # optional: the value that the question is about

[evaluation]                       # optional
agents = 1024
steps = 1000

[[axis]]                           # cells are the product of all axes: see `axes.py`
label = "hidden units"
field = "network.hidden"
values = [5, 10, 20]

[[cell]]                           # in place of axes: a list of cells, written as choices

A cell that learns in one world and is measured in another says measured_in = "NAME".
Every cell is checked before anything runs. Paths of worlds are relative to the current folder.
"""

import itertools
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from reflexarc_runtime.config.checks import require
from reflexarc_runtime.config.fill import fill
from reflexarc_runtime.config.key_path import KeyPath
from reflexarc_runtime.config.toml_source import TomlSource, read_text
from reflexarc_runtime.errors import ReflexarcError, UsageError
from reflexarc_sim_bridge.evaluation.metrics.edge_index import require_edge_index
from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.study.axes import Axis, AxisTable, Choice, read_axes, require_words
from reflexarc_trainer.study.settings import configured, measured_in
from reflexarc_trainer.study.targets import Target
from reflexarc_trainer.study.unit import Evaluation, Measure, Unit

MOST_UNITS = 10_000
MOST_SEEDS = 1000

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,59}")


@dataclass(frozen=True)
class Cell:
    """One configuration of the grid, which is run with every seed."""

    choices: tuple[Choice, ...]
    """One per axis, in the order of the axes."""
    config: TrainConfig
    """The configuration; its seed is replaced."""
    measured_in: str = ""
    """The world that it is measured in; "" for that of the study, or of its own learning."""

    @property
    def name(self) -> str:
        """Names of its choices, separated by commas."""
        return ", ".join(choice.name for choice in self.choices)


@dataclass(frozen=True)
class Study:
    """A study whose cells have been checked."""

    name: str
    """Name of the file, without its suffix."""
    title: str
    question: str
    measure: Measure
    seeds: tuple[int, ...]
    evaluation: Evaluation
    axes: tuple[Axis, ...]
    cells: tuple[Cell, ...]
    targets: tuple[Target, ...]
    asked: str
    """Name of the choice that the question asks about; "" for none."""
    text: str = field(repr=False)
    """Content of the file."""

    def unit(self, cell: Cell, seed: int) -> Unit:
        """The unit of a cell and a seed."""
        scale = _scale_of(self.evaluation, cell.measured_in)
        return Unit(replace(cell.config, seed=seed), scale, self.measure)

    def units(self) -> list[Unit]:
        """All units, seed by seed, so that an interrupted study has results of every cell."""
        return [self.unit(cell, seed) for seed in self.seeds for cell in self.cells]


def read_study(path: Path) -> Study:
    """Read and check a study.

    Raises:
        ReflexarcError: the file cannot be read, or a cell of it cannot be run; with line and field.
    """
    name = path.stem
    if not _NAME.fullmatch(name):
        raise UsageError(f"{path}: expected a name of letters, digits, - and _, got {name!r}")
    return parse_study(read_text(path, str(path)), name, str(path))


def parse_study(text: str, name: str, where: str = "") -> Study:
    """Read and check a study from its text; `where` names it in error messages."""
    source = TomlSource(text, where)
    head = fill(_Head, source)
    axes = tuple(read_axes(source, head.axis, head.cell))
    seeds = _seeds(source, head.seeds)
    cells = tuple(_cells(source, head, axes))
    study = Study(
        name=name,
        title=head.title,
        question=" ".join(head.question.split()),
        measure=head.measure,
        seeds=seeds,
        evaluation=head.evaluation,
        axes=axes,
        cells=cells,
        targets=head.target,
        asked=head.asked,
        text=text,
    )
    _check_whole(source, study)
    return study


@dataclass(frozen=True)
class _Head:
    """The content of the file, before its cells are read."""

    title: str
    question: str
    preset: str = "reflex"
    seeds: object = 10
    steps: int = 0
    measure: Measure = Measure.CONTACTS
    evaluation: Evaluation = field(default_factory=Evaluation)
    axis: tuple[AxisTable, ...] = ()
    cell: tuple[object, ...] = ()
    target: tuple[Target, ...] = ()
    asked: str = ""

    def __post_init__(self) -> None:
        require_words("title", self.title)
        require(self.steps >= 0, "steps", "1 or more, or 0 for the preset's", self.steps)
        alone = not (self.axis and self.cell)
        require(alone, "cell", "either axes or cells, not both", "both")
        require(bool(self.axis or self.cell), "axis", "an [[axis]] or a [[cell]]", "none")


def _seeds(source: TomlSource, given: Any) -> tuple[int, ...]:
    """The seeds, of a number of seeds or of a list."""
    seeds = list(range(min(given, MOST_SEEDS + 1))) if type(given) is int else given
    whole = isinstance(seeds, list) and all(type(s) is int and 0 <= s < 1 << 63 for s in seeds)
    if not whole or not 1 <= len(seeds) <= MOST_SEEDS or len(set(seeds)) < len(seeds):
        wanted = f"1 to {MOST_SEEDS}, or a list of different seeds"
        raise source.complaint(("seeds",), f"expected {wanted}, got {str(given)[:60]}")
    return tuple(seeds)


def _cells(source: TomlSource, head: _Head, axes: tuple[Axis, ...]) -> Iterator[Cell]:
    """The product of all axes' choices; the last axis varies fastest."""
    count = math.prod(len(axis.choices) for axis in axes)
    if count > MOST_UNITS:
        raise source.complaint(("axis",), f"expected at most {MOST_UNITS} cells, got {count}")
    for choices in itertools.product(*(axis.choices for axis in axes)):
        yield _cell(source, head, choices)


def _cell(source: TomlSource, head: _Head, choices: tuple[Choice, ...]) -> Cell:
    """A cell whose configuration, eye and worlds have been checked."""
    settings: dict[str, object] = {"steps": head.steps} if head.steps else {}
    for choice in choices:
        settings |= choice.settings
    cell_name = ", ".join(choice.name for choice in choices)
    try:
        config = configured(head.preset, settings)
        elsewhere = measured_in(settings)
        unit = Unit(config, _scale_of(head.evaluation, elsewhere), head.measure)
        for world in (*config.worlds, unit.world):
            if world is not None:
                world.source()
        if head.measure is Measure.EDGE_INDEX and unit.world is not None:
            require_edge_index(unit.world.source())
    except ReflexarcError as error:
        raise source.complaint(_blamed(choices, str(error)), f"{cell_name}: {error}") from None
    return Cell(choices, config, elsewhere)


def _scale_of(evaluation: Evaluation, measured_in: str) -> Evaluation:
    return replace(evaluation, world=measured_in) if measured_in else evaluation


def _blamed(choices: tuple[Choice, ...], complaint: str) -> KeyPath:
    """The place of the setting that an error message begins with; else of the last choice."""
    field_name = complaint.partition(":")[0]
    for choice in reversed(choices):
        for name, path in choice.paths.items():
            if name.endswith(field_name):
                return path
    return choices[-1].path


def _check_whole(source: TomlSource, study: Study) -> None:
    """Check the number of runs, that all cells differ, and that targets name cells."""
    count = len(study.cells) * len(study.seeds)
    if count > MOST_UNITS:
        raise source.complaint(("seeds",), f"expected at most {MOST_UNITS} runs, got {count}")
    names: dict[str, str] = {}
    for cell in study.cells:
        other = names.setdefault(study.unit(cell, 0).hash, cell.name)
        if other != cell.name:
            words = f"expected different cells, got the same run as {other} and as {cell.name}"
            raise source.complaint(cell.choices[-1].path, words)
    choices = [choice.name for axis in study.axes for choice in axis.choices]
    if study.asked and study.asked not in choices:
        words = f"expected one of {', '.join(choices)}, got {study.asked!r}"
        raise source.complaint(("asked",), words)
    for n, target in enumerate(study.targets):
        if target.cell not in names.values():
            known = ", ".join(names.values())
            words = f"expected one of {known}, got {target.cell!r}"
            raise source.complaint(("target", n, "cell"), words)
