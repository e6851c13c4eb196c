"""The page of a run, its pictures, its event files."""

import dataclasses
import math
import sys
from pathlib import Path

import numpy as np
import pytest

from reflexarc_runtime.errors import UsageError
from reflexarc_trainer.config.presets import preset_named
from reflexarc_trainer.config.train_config import TrainConfig, TrainingWorld
from reflexarc_trainer.policy.q_network import new_network
from reflexarc_trainer.run.history import Row, best_of, has_reached
from reflexarc_trainer.run.plots import draw_occupancy, lateral_places_m
from reflexarc_trainer.run.report import telling_ones, write_report
from reflexarc_trainer.run.tensorboard_files import event_files
from reflexarc_trainer.run.validation import validate

ROWS = [Row(100, 1.0, 0.5, 0.2, 40.0, 9.0), Row(200, 2.0, 0.1, 0.1, 20.0, 7.0)]


EMPTY = TrainingWorld("empty", text='name = "empty"\nlayers = []\n')


def rows(*scores: float) -> list[Row]:
    return [ROWS[0]._replace(validation_contacts_per_100m=score) for score in scores]


def test_page_says_what_was_learned_and_from_what() -> None:
    config = TrainConfig(seed=7)
    network = new_network(config.contract(), config.network, seed=7)
    page = write_report(network, config, 200, [*ROWS, ROWS[0]._replace(step=300)])
    assert page.startswith("# reflex, seed 7\n")
    assert "7.00 contacts per 100 m on validation worlds, after 200 steps" in page
    assert "9.00 contacts per 100 m on validation worlds, after 300 steps" in page
    assert "36.0 contacts per 100 m" in page
    for word in (config.hash, "`reference-1`", "16–10–3", "(curve.png)", "(occupancy.png)"):
        assert word in page
    assert len(page.splitlines()) < 60


@pytest.mark.parametrize("name", ["binocular", "rover"])
def test_page_of_other_eyes_and_motions_has_a_value_for_every_action(name: str) -> None:
    config = preset_named(name)
    network = new_network(config.contract(), config.network, seed=1)
    page = write_report(network, config, 0, [])
    decisions = page.partition("## What it decides")[2].partition("## Where")[0]
    table = [line for line in decisions.splitlines() if line.startswith("|")]
    assert len({line.count(" | ") for line in table}) == 1
    assert all(line.count("**") == 2 for line in table[2:])


def test_telling_decisions_are_the_surest_of_each_action_and_the_closest_call() -> None:
    q_values = np.array([[3.0, 0, 0], [5, 4, 4], [0, 1, 0.9], [2, 9, 0], [7, 1, 0]], np.float32)
    actions = np.argmax(q_values, axis=1)
    assert telling_ones(q_values, actions) == [4, 3, 2]


def test_occupancy_of_an_agent_that_never_steers_is_even() -> None:
    config = TrainConfig(worlds=(EMPTY,))
    network = new_network(config.contract(), config.network, seed=0)
    with_bias = network.output.bias.detach()
    with_bias[:] = with_bias.new_tensor([50.0, 0.0, 0.0])
    places_m = lateral_places_m(network, config)
    assert places_m.shape == (256 * 20,)
    counts, _ = np.histogram(places_m, bins=4, range=(0.0, 20.0))
    # 256 agents: the standard deviation of a quarter's share is sqrt(1/4 · 3/4 / 256) = 0.027.
    np.testing.assert_allclose(counts / len(places_m), 0.25, atol=4 * 0.027)
    assert draw_occupancy(network, config).startswith(b"\x89PNG")


def test_best_point_is_the_first_of_equals() -> None:
    history = [row._replace(step=i) for i, row in enumerate(rows(3.0, 2.0, 2.0))]
    assert best_of(history) == history[1]
    assert best_of([]) is None


@pytest.mark.parametrize(
    ("scores", "goal", "reached"),
    [
        ((9.0, 5.0, 5.0), 5.0, True),
        ((5.0, 9.0, 5.0), 5.0, False),
        ((4.0, 4.0, 9.0), 5.0, False),
        ((4.0,), 5.0, False),
        ((4.0, math.nan), 5.0, False),
        ((4.0, 4.0), None, False),
    ],
)
def test_goal_is_reached_by_the_last_two_points(
    scores: tuple[float, ...], goal: float | None, reached: bool
) -> None:
    assert has_reached(rows(*scores), goal) is reached


def test_turning_body_is_measured_by_its_path() -> None:
    """Turning left for ever where nothing is: no contacts, and no progress along x either."""
    config = dataclasses.replace(preset_named("rover"), worlds=(EMPTY,))
    network = new_network(config.contract(), config.network, seed=0)
    bias = network.output.bias.detach()
    bias[:] = bias.new_tensor([0.0, 50.0, 0.0])
    assert validate(network, config) == 0.0
    actions = [(a.name, a.linear_mps, a.angular_radps) for a in config.contract().actions]
    assert actions == [("stay", 1.0, 0.0), ("left", 1.0, 2.0), ("right", 1.0, -2.0)]


def test_the_metres_of_a_turning_body_are_those_that_it_drives() -> None:
    """Straight on it meets what a blind agent meets, 36 contacts per 100 m of its path."""
    rover, field = preset_named("rover"), (TrainingWorld("reference-1"),)
    config = dataclasses.replace(rover, worlds=field)
    assert config.learner.exploration.action_repeat > 1
    network = new_network(config.contract(), config.network, seed=0)
    bias = network.output.bias.detach()
    bias[:] = bias.new_tensor([50.0, 0.0, 0.0])
    assert validate(network, config) == pytest.approx(36.0, rel=0.1)


def test_without_tensorboard_the_flag_is_refused_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "torch.utils.tensorboard", None)
    with pytest.raises(UsageError, match=r"pip install 'reflexarc\[tensorboard\]'") as refusal:
        event_files(tmp_path).__enter__()
    assert "\n" not in str(refusal.value)


def test_event_files_hold_every_point_and_a_resumed_run_adds_to_them(tmp_path: Path) -> None:
    reading = pytest.importorskip("tensorboard.backend.event_processing.event_accumulator")
    for row in (ROWS[0], ROWS[1]):
        with event_files(tmp_path) as measured:
            measured(row)
    events = reading.EventAccumulator(str(tmp_path / "tensorboard")).Reload()
    points = events.Scalars("validation_contacts_per_100m")
    assert [(point.step, point.value) for point in points] == [(100, 9.0), (200, 7.0)]
    assert set(events.Tags()["scalars"]) == set(Row._fields) - {"step"}
