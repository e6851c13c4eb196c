"""The page of a run."""

import numpy as np
import pytest

from reflexarc_trainer.config.presets import preset_named
from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.policy.q_network import new_network
from reflexarc_trainer.run.history import Row
from reflexarc_trainer.run.report import examples, write_report

ROWS = [Row(100, 1.0, 0.5, 0.2, 40.0, 9.0), Row(200, 2.0, 0.1, 0.1, 20.0, 7.0)]


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


def test_examples_are_the_surest_decision_of_each_action_and_the_closest_call() -> None:
    q_values = np.array([[3.0, 0, 0], [5, 4, 4], [0, 1, 0.9], [2, 9, 0], [7, 1, 0]], np.float32)
    actions = np.argmax(q_values, axis=1)
    assert examples(q_values, actions) == [4, 3, 2]
