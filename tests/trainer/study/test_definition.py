"""Study files: which cells they make, and where they are wrong."""

import dataclasses
import math
from pathlib import Path

import pytest

from reflexarc_runtime.contract.eye import Shading
from reflexarc_runtime.errors import ReflexarcError, UsageError
from reflexarc_trainer.config.presets import PRESETS
from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.study.definition import Study, parse_study, read_study
from reflexarc_trainer.study.settings import configured
from reflexarc_trainer.study.shipped import study_named, study_names
from reflexarc_trainer.study.unit import Measure

HEAD = """\
title = "Nothing in particular"
question = "What if?"
preset = "online"
"""

GRID = f"""{HEAD}
seeds = [4, 9]
steps = 3000

[[axis]]
label = "hidden units"
field = "network.hidden"
values = [5, 20]

[[axis]]
label = "eye"

[[axis.choice]]
name = "as it is"

[[axis.choice]]
name = "literal"
"retina.shading" = "colour"
retina.range_m = 2
"""


def parsed(text: str) -> Study:
    return parse_study(text, "mine", "mine.toml")


def test_cells_are_the_product_of_the_axes() -> None:
    study = parsed(GRID)
    names = ["5, as it is", "5, literal", "20, as it is", "20, literal"]
    assert [cell.name for cell in study.cells] == names
    assert [cell.config.network.hidden for cell in study.cells] == [(5,), (5,), (20,), (20,)]
    assert study.cells[1].config.retina.shading is Shading.COLOUR
    assert study.cells[1].config.retina.range_m == 2.0
    assert {cell.config.steps for cell in study.cells} == {3000}
    assert [axis.is_numeric for axis in study.axes] == [True, False]


def test_every_cell_runs_with_every_seed_and_seeds_come_in_turn() -> None:
    study = parsed(GRID)
    units = study.units()
    assert [unit.config.seed for unit in units] == [4] * 4 + [9] * 4
    assert len({unit.hash for unit in units}) == 8
    for unit, cell in zip(units[4:], study.cells, strict=True):
        assert unit.config == dataclasses.replace(cell.config, seed=9)


def test_a_list_of_cells_needs_no_axes() -> None:
    text = f'{HEAD}[[cell]]\nname = "a"\n[[cell]]\nname = "b"\npreset = "reflex"\nsteps = 7\n'
    first, second = parsed(text).cells
    assert (first.name, first.config) == ("a", PRESETS["online"])
    assert second.config == dataclasses.replace(PRESETS["reflex"], steps=7)
    assert parsed(text).seeds == tuple(range(10))


def test_fields_are_set_at_once_so_that_their_order_does_not_matter() -> None:
    deep = {"learner.form": "batched", "network.hidden": [16, 8]}
    for settings in (deep, dict(reversed(deep.items()))):
        config = configured("online", settings)
        assert (config.network.hidden, config.learner.form) == ((16, 8), "batched")


def test_settings_take_what_a_file_can_say() -> None:
    settings = {"worlds": ["tier-05:1", "tier-15:3"], "retina.fov_rad": 1, "preset": "paper"}
    config = configured("reflex", settings)
    assert [(world.name, world.share) for world in config.worlds] == [
        ("tier-05", 1.0),
        ("tier-15", 3.0),
    ]
    assert isinstance(config.retina.fov_rad, float)
    assert config.preset == "paper"
    assert configured("reflex", {}) == PRESETS["reflex"]
    assert isinstance(configured("reflex", {}), TrainConfig)


CELL = f'{HEAD}[[cell]]\nname = "a"\n'
AXIS = f'{HEAD}[[axis]]\nlabel = "x"\n'

WRONG: dict[str, tuple[str, str]] = {
    "no TOML": ("title = ", "mine.toml:1: expected TOML"),
    "no question": ('title = "a"\n', "question: missing"),
    "unknown key": (f"{HEAD}speed = 1\n", "mine.toml:4: speed: unknown"),
    "no cell": (HEAD, "expected an [[axis]] or a [[cell]]"),
    "both": (f'{CELL}[[axis]]\nlabel = "x"\nfield = "steps"\nvalues = [1]\n', "not both"),
    "seeds": (f"{HEAD}seeds = 0\n{AXIS[len(HEAD) :]}field = 'steps'\nvalues = [1]\n", ":4: seeds"),
    "same seeds": (
        f"{HEAD}seeds = [1, 1]\n[[cell]]\nname = 'a'\n",
        "mine.toml:4: seeds: expected 1 to 1000, or a list of different seeds",
    ),
    "no values": (f'{AXIS}field = "steps"\n', "mine.toml:4: axis[0].values"),
    "values of nothing": (f"{AXIS}values = [1]\n", "axis[0].values"),
    "values are no list": (f'{AXIS}field = "steps"\nvalues = 5\n', "axis[0].values"),
    "same values": (f'{AXIS}field = "steps"\nvalues = [5, 5]\n', "expected different values"),
    "scale": (f'{AXIS}field = "steps"\nvalues = [5]\nscale = "cubic"\n', "linear or log"),
    "log of zero": (
        f'{AXIS}field = "learner.trace_decay"\nvalues = [0.1, 0]\nscale = "log"\n',
        "axis[0].values[1]: expected a number above 0, for scale = 'log', got 0",
    ),
    "mathematics": (f'{HEAD}[[cell]]\nname = "$a$"\n', "without | and $"),
    "no field": (
        f'{AXIS}field = "network.depth"\nvalues = [1]\n',
        "mine.toml:7: axis[0].values[0]: network.depth: no such field; known: hidden",
    ),
    "group": (f'{AXIS}field = "network"\nvalues = [1]\n', "expected one of its fields"),
    "field of a field": (f'{AXIS}field = "steps.x"\nvalues = [1]\n', "steps.x: no such field"),
    "type": (
        f'{CELL}learner.gamma = "high"\n',
        "mine.toml:4: cell[0]: learner.gamma: expected a number, got 'high'",
    ),
    "truth": (f"{CELL}learner.gamma = true\n", "expected a number, got True"),
    "choice": (f'{CELL}"learner.form" = "offline"\n', "expected online or batched"),
    "shading": (f'{CELL}"retina.shading" = 3\n', "expected colour or nearness"),
    "list": (
        f'{CELL}"network.hidden" = ["a"]\n',
        "network.hidden[0]: expected a whole number, got 'a'",
    ),
    "out of range": (
        f'{CELL}\n"learner.gamma" = 1.5\n',
        "mine.toml:7: cell[0].'learner.gamma': a: learner.gamma: expected in [0, 1)",
    ),
    "together": (
        f'{CELL}"network.hidden" = [5, 5]\n',
        "a: network.hidden: expected one layer with learner.form = 'online'",
    ),
    "preset": (f'{CELL}preset = "zebra"\n', "no preset is named 'zebra'"),
    "head preset": (CELL.replace("online", "zebra"), "no preset is named 'zebra'"),
    "world": (f'{CELL}worlds = "atlantis"\n', "no world is named 'atlantis'"),
    "worlds": (f"{CELL}worlds = 3\n", "worlds: expected a text, got 3"),
    "seed": (f"{CELL}seed = 3\n", "seed: cannot be set in a cell; use `seeds`"),
    "validation": (f"{CELL}validation.points = 3\n", "cannot be set in a cell"),
    "turning": (f'{CELL}preset = "rover"\n', "motion: expected sideways"),
    "name": (f"{HEAD}[[cell]]\nsteps = 3\n", "mine.toml:4: cell[0].name: expected a table"),
    "line break": (f'{HEAD}[[cell]]\nname = "a\\nb"\n', "printable characters"),
    "same cells": (
        f'{CELL}[[cell]]\nname = "b"\n',
        "expected different cells, got the same run as a and as b",
    ),
    "agents": (f"{HEAD}[evaluation]\nagents = 0\n[[cell]]\nname='a'\n", ":5: evaluation.agents"),
    "evaluation world": (
        f"{HEAD}[evaluation]\nworld = 'atlantis'\n[[cell]]\nname='a'\n",
        "no world is named 'atlantis'",
    ),
    "target": (f'{CELL}[[target]]\ncell = "b"\neach_at_most = 1\n', "expected one of a, got 'b'"),
    "bound": (f'{CELL}[[target]]\ncell = "a"\n', "a target with a bound"),
    "edges": (
        f'{HEAD}measure = "edge_index"\n[[cell]]\nname = "a"\nworlds = "gates"\n',
        "gates: expected one world of scattered obstacles",
    ),
    "too many": (
        f"{HEAD}seeds = 1000\n{AXIS[len(HEAD) :]}field = 'steps'\nvalues = {list(range(1, 12))}\n",
        "expected at most 10000 runs, got 11000",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_is_wrong_is_told_in_one_line_with_its_place(case: str) -> None:
    text, said = WRONG[case]
    with pytest.raises(ReflexarcError) as refusal:
        parsed(text)
    assert said in str(refusal.value)
    assert "\n" not in str(refusal.value)
    assert str(refusal.value).startswith("mine.toml:")


@pytest.mark.parametrize("name", ["-x.toml", "a b.toml", ".toml"])
def test_the_files_name_becomes_a_folders(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(GRID)
    with pytest.raises(UsageError, match="expected a name"):
        read_study(tmp_path / name)


def test_unknown_study_is_refused_with_those_that_there_are() -> None:
    with pytest.raises(UsageError, match="none is named 'zebra'; known: alpha"):
        study_named("zebra")
    with pytest.raises(UsageError, match="cannot be read"):
        study_named("no/such.toml")


@pytest.mark.parametrize("name", study_names())
def test_every_study_that_is_shipped_can_be_run(name: str) -> None:
    study = study_named(name)
    assert len(study.seeds) >= 5
    assert study.question.endswith("?")


def test_the_studies_of_the_paper_are_shipped() -> None:
    wanted = {"hidden", "eyes", "alpha", "lambda", "gamma", "eye-range", "output", "form", "held"}
    assert wanted | {"edge", "lambda-suite", "self-knowledge", "thirty"} == set(study_names())
    thirty = study_named("thirty")
    assert (len(thirty.seeds), thirty.measure) == (30, Measure.SHARE_OF_BLIND)


def test_the_papers_values_are_among_those_that_are_studied() -> None:
    for name, value in (("alpha", 0.5), ("lambda", 0.9), ("gamma", 0.9), ("hidden", 10.0)):
        numbers = [c.number for axis in study_named(name).axes for c in axis.choices]
        assert value in numbers


def test_two_eyes_are_compared_at_equal_rays_equal_rays_an_eye_and_equal_fields() -> None:
    eyes = {cell.choices[1].name: cell.config.retina for cell in study_named("eyes").cells[-6:]}
    assert eyes["one of 16, 180°"].size == eyes["two of 8, 180°"].size
    assert eyes["one of 16, 180°"].rays == eyes["two of 16, 180°"].rays
    assert eyes["one of 8, 90°"].fov_rad == eyes["two of 8, 90°"].fov_rad == math.pi / 2


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ('measured_in = "nowhere"', "measured_in: world: no world is named 'nowhere'"),
        ("measured_in = 3", "measured_in: expected a text, got 3"),
    ],
)
def test_a_world_to_be_measured_in_must_be_there(change: str, complaint: str) -> None:
    with pytest.raises(ReflexarcError, match=complaint):
        parsed(f'{HEAD}[[cell]]\nname = "a"\n{change}\n')


def test_cells_that_learn_alike_and_are_measured_elsewhere_are_two() -> None:
    cell = '[[cell]]\nname = "a"\n[[cell]]\nname = "b"\n'
    study = parsed(f'{HEAD}{cell}measured_in = "askew-30"\n')
    units = study.units()[:2]
    assert units[0].config == units[1].config
    assert [unit.world.name for unit in units if unit.world] == ["reference-1", "askew-30"]
    with pytest.raises(ReflexarcError, match="expected different cells"):
        parsed(HEAD + cell)


def test_what_is_asked_about_must_be_one_of_the_choices() -> None:
    assert parsed(f'asked = "20"\n{GRID}').asked == "20"
    with pytest.raises(ReflexarcError, match=r"mine.toml:1: asked: expected one of 5, 20, as it"):
        parsed(f'asked = "7"\n{GRID}')


def test_nobody_tells_the_policy_of_its_body() -> None:
    """Eye, motion and network are the same in all cells; only worlds differ."""
    cells = study_named("self-knowledge").cells
    assert len({(c.config.retina, c.config.network, c.config.motion) for c in cells}) == 1
    assert {c.config.worlds for c in cells if c.measured_in} == {cells[0].config.worlds}
