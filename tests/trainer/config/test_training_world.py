"""Worlds to learn in: their shares of a run, and how a command line names them."""

import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_runtime.errors import ReflexarcError, UsageError, WorldError
from reflexarc_sim_bridge.worlds.files import world_text
from reflexarc_trainer.config.train_config import TrainConfig, TrainingWorld
from reflexarc_trainer.config.training_world import parse_training_world, stage_at, stage_ends

WORLDS = (TrainingWorld("tier-05", 1.0), TrainingWorld("tier-30", 3.0))


@given(st.lists(st.floats(0.01, 100.0), min_size=1, max_size=6), st.floats(0.0, 1.0))
def test_each_world_has_its_share_of_the_run(shares: list[float], done: float) -> None:
    worlds = [TrainingWorld("plane", share) for share in shares]
    stage = stage_at(stage_ends(worlds, 1000.0), 1000.0 * done)
    before, behind = sum(shares[:stage]), sum(shares[: stage + 1])
    assert before / sum(shares) <= done + 1e-9
    assert stage == len(worlds) - 1 or done - 1e-9 <= behind / sum(shares)


def test_a_run_that_goes_on_beyond_its_end_stays_in_the_last_world() -> None:
    assert stage_at(stage_ends(WORLDS, 100.0), 1e9) == 1
    assert stage_ends(WORLDS, 100.0) == [25.0, math.inf]


def test_hash_covers_the_text_of_the_world_and_the_run_keeps_it(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(world_text("tier-05"))
    first = TrainConfig(worlds=(TrainingWorld(str(path)),))
    path.write_text(world_text("tier-30"))
    second = TrainConfig(worlds=(TrainingWorld(str(path)),))
    assert first.hash != second.hash
    path.unlink()
    again = TrainConfig.from_resolved(first.resolved())
    assert again == first
    assert again.goal_world.name == "tier-05"


def test_words_of_the_command_line_are_a_name_and_a_share(tmp_path: Path) -> None:
    assert parse_training_world("tier-05") == TrainingWorld("tier-05", 1.0)
    assert parse_training_world("tier-05:0.25") == TrainingWorld("tier-05", 0.25)
    path = tmp_path / "a world.toml"
    path.write_text(world_text("plane"))
    assert parse_training_world(f"{path}:2").share == 2.0


@pytest.mark.parametrize(
    ("words", "kind", "said"),
    [
        ("tier-05:much", UsageError, "expected NAME or NAME:SHARE"),
        ("tier-05:0", UsageError, "share: expected positive"),
        ("tier-05:nan", UsageError, "share: expected positive"),
        ("atlantis", WorldError, "atlantis"),
        ("no/file.toml:1", WorldError, "no/file.toml"),
    ],
)
def test_words_that_name_no_world_are_refused_in_one_line(
    words: str, kind: type[ReflexarcError], said: str
) -> None:
    with pytest.raises(kind, match=said) as refusal:
        parse_training_world(words)
    assert "\n" not in str(refusal.value)
