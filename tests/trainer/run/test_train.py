"""A run: its files, its determinism, its interruption, and that it learns."""

import csv
import dataclasses
import functools
import json
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.policy.policy import load_policy
from reflexarc_trainer.config.presets import preset_named
from reflexarc_trainer.config.train_config import (
    LearnerConfig,
    NetworkConfig,
    OnlineConfig,
    TrainConfig,
    ValidationConfig,
)
from reflexarc_trainer.policy.weights import NetworkPolicy, network_of
from reflexarc_trainer.run import checkpoint, train
from reflexarc_trainer.run.train import TrainingProgress
from reflexarc_trainer.sarsa.forms import new_learner
from reflexarc_trainer.sarsa.learner_interface import Learner

WITHOUT_A_POINT = {
    *("policy.onnx", "config.json", "metrics.csv", "checkpoint.npz"),
    *("report.md", "curve.png", "occupancy.png"),
}
FILES = WITHOUT_A_POINT | {"policy-best.onnx"}


def names(folder: Path) -> set[str]:
    return {path.name for path in folder.iterdir()}


def stop_after(steps: int) -> tuple[Callable[[TrainingProgress], None], Callable[[], bool]]:
    """A progress listener and a `should_stop` that says yes once `steps` are done."""
    seen = [0]

    def listen(progress: TrainingProgress) -> None:
        seen[0] = progress.step

    return listen, lambda: seen[0] >= steps


def test_run_leaves_its_files_and_nothing_else(
    config: TrainConfig, whole_run: train.TrainResult
) -> None:
    folder = whole_run.policy_path.parent
    assert names(folder) == FILES
    assert (whole_run.steps, whole_run.interrupted) == (config.steps, False)
    document = json.loads((folder / "config.json").read_text())
    assert TrainConfig.from_resolved(document["config"]) == config
    assert document["config_hash"] == config.hash
    assert (folder / "curve.png").read_bytes().startswith(b"\x89PNG")


def test_metrics_have_a_row_a_validation_point(
    config: TrainConfig, whole_run: train.TrainResult
) -> None:
    text = (whole_run.policy_path.parent / "metrics.csv").read_text()
    rows = list(csv.DictReader(text.splitlines()))
    assert [int(row["step"]) for row in rows] == [
        config.steps * point // 4 for point in (1, 2, 3, 4)
    ]
    epsilons = [float(row["epsilon"]) for row in rows]
    assert epsilons == pytest.approx([0.51, 0.02, 0.02, 0.02])
    assert [float(row["validation_contacts_per_100m"]) for row in rows] == pytest.approx(
        [row.validation_contacts_per_100m for row in whole_run.history], rel=1e-5
    )
    assert all(float(row["mean_abs_error"]) > 0.0 for row in rows)


def test_policy_is_that_of_the_last_weights(
    config: TrainConfig, whole_run: train.TrainResult
) -> None:
    result, folder = whole_run, whole_run.policy_path.parent
    retinas = np.random.default_rng(0).integers(0, 256, (50, 1, 1, 16, 1), np.uint8)
    network = network_of(checkpoint.load(folder / "checkpoint.npz").learner()).float().double()
    from_torch, _ = NetworkPolicy(network).decide(retinas)
    for backend in ("numpy", "onnxruntime"):
        q_values, _ = load_policy(result.policy_path, backend).decide(retinas)
        np.testing.assert_allclose(q_values, from_torch, atol=2e-6)
    provenance = load_policy(result.policy_path).contract.provenance
    assert (provenance.seed, provenance.config_hash) == (3, config.hash)
    score = result.history[-1].validation_contacts_per_100m
    assert provenance.scores["validation_contacts_per_100m"] == score


def test_same_seed_gives_the_same_bytes(
    config: TrainConfig, whole_run: train.TrainResult, tmp_path: Path
) -> None:
    first, second = whole_run.policy_path, train.train(config, tmp_path).policy_path
    assert first.read_bytes() == second.read_bytes()
    saved = [checkpoint.load(p.parent / "checkpoint.npz").arrays for p in (first, second)]
    assert saved[0]["weights"].tobytes() == saved[1]["weights"].tobytes()


def test_other_seed_gives_other_weights(config: TrainConfig) -> None:
    other = dataclasses.replace(config, seed=4)
    learners = [new_learner(config) for config in (config, other)]
    for learner in learners:
        learner.run(160)
    assert not np.array_equal(*(learner.arrays()["weights"] for learner in learners))


def test_how_a_run_is_cut_into_calls_changes_nothing(config: TrainConfig) -> None:
    whole, pieces = new_learner(config), new_learner(config)
    whole.run(960)
    while pieces.step < whole.step:
        pieces.run(min(170, whole.step - pieces.step))
    assert same_arrays(whole, pieces)


def same_arrays(one: Learner, other: Learner) -> bool:
    mine, theirs = one.arrays(), other.arrays()
    return mine.keys() == theirs.keys() and all(
        mine[name].tobytes() == theirs[name].tobytes() for name in mine
    )


@pytest.mark.parametrize("after", [0, 1200])
def test_resumed_run_equals_an_uninterrupted_one(
    after: int, config: TrainConfig, whole_run: train.TrainResult, tmp_path: Path
) -> None:
    listen, should_stop = stop_after(after)
    broken = train.train(config, tmp_path, progress=listen, should_stop=should_stop)
    assert broken.interrupted
    assert after <= broken.steps < after + 320
    assert names(tmp_path) == (FILES if broken.history else WITHOUT_A_POINT)
    mended = train.resume(tmp_path)
    assert (mended.steps, mended.interrupted) == (config.steps, False)
    assert_same_run(mended, whole_run)


def test_run_interrupted_at_three_random_steps_equals_an_uninterrupted_one(
    config: TrainConfig,
    whole_run: train.TrainResult,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(train, "CHUNK_STEPS", 23)
    stops = np.sort(np.random.default_rng().choice(config.steps - 400, 3, replace=False))
    print(f"interrupted after {stops}")  # said where it fails
    begin: Callable[..., train.TrainResult] = functools.partial(train.train, config)
    for after in stops.tolist():
        listen, should_stop = stop_after(after)
        assert begin(tmp_path, progress=listen, should_stop=should_stop).interrupted
        begin = train.resume
    assert_same_run(train.resume(tmp_path), whole_run)


def assert_same_run(one: train.TrainResult, other: train.TrainResult) -> None:
    """The same policies and state to the bit, the same history but for the time it took."""
    assert one.policy_path.read_bytes() == other.policy_path.read_bytes()
    assert one.best_policy_path.read_bytes() == other.best_policy_path.read_bytes()
    saved = [checkpoint.load(run.policy_path.parent / "checkpoint.npz") for run in (one, other)]
    assert same_arrays(*(each.learner() for each in saved))
    assert saved[0].best.tobytes() == saved[1].best.tobytes()
    rows = [[row._replace(seconds=0.0) for row in run.history] for run in (one, other)]
    assert rows[0] == rows[1]


def test_run_ends_where_two_points_in_a_row_are_good_enough(
    config: TrainConfig, whole_run: train.TrainResult, tmp_path: Path
) -> None:
    scores = [row.validation_contacts_per_100m for row in whole_run.history]
    goal = min(max(pair) for pair in pairwise(scores[:-1]))
    ends = next(i for i, pair in enumerate(pairwise(scores)) if max(pair) <= goal) + 2
    wanted = dataclasses.replace(config.validation, stop_at=goal)
    listen, should_stop = stop_after(700)
    config = dataclasses.replace(config, validation=wanted)
    assert not train.train(config, tmp_path, progress=listen, should_stop=should_stop).reached
    early = train.resume(tmp_path)
    assert (early.reached, early.interrupted, len(early.history)) == (True, False, ends)
    assert [row.validation_contacts_per_100m for row in early.history] == scores[:ends]
    assert train.resume(tmp_path).steps == early.steps == whole_run.history[ends - 1].step


def test_best_policy_is_that_of_the_best_validation_point(
    config: TrainConfig, whole_run: train.TrainResult, tmp_path: Path
) -> None:
    points = list(whole_run.history)
    best = points[int(np.argmin([row.validation_contacts_per_100m for row in points]))]
    assert whole_run.best == best
    scores = load_policy(whole_run.best_policy_path).contract.provenance.scores
    assert scores == {
        "steps": best.step,
        "validation_contacts_per_100m": best.validation_contacts_per_100m,
    }
    listen, should_stop = stop_after(best.step)
    until_then = train.train(config, tmp_path, progress=listen, should_stop=should_stop)
    q_values = [
        load_policy(path).decide(np.full((1, 1, 1, 16, 1), 77, np.uint8))[0]
        for path in (whole_run.best_policy_path, until_then.policy_path)
    ]
    assert q_values[0].tobytes() == q_values[1].tobytes()


def test_new_run_removes_the_results_of_an_earlier_one(config: TrainConfig, tmp_path: Path) -> None:
    (tmp_path / "policy-best.onnx").write_text("of something else")
    train.train(config, tmp_path, should_stop=lambda: True)
    assert names(tmp_path) == WITHOUT_A_POINT


def test_run_killed_before_its_first_point_leaves_no_earlier_checkpoint(
    config: TrainConfig, tmp_path: Path
) -> None:
    def die() -> bool:
        raise SystemExit

    (tmp_path / "checkpoint.npz").write_text("of something else")
    with pytest.raises(SystemExit):
        train.train(config, tmp_path, should_stop=die)
    assert names(tmp_path) == {"config.json"}


def test_progress_says_rate_and_error(config: TrainConfig, tmp_path: Path) -> None:
    seen: list[TrainingProgress] = []
    result = train.train(config, tmp_path, progress=seen.append)
    assert all(where.steps_per_s > 0.0 and where.mean_abs_error > 0.0 for where in seen)
    # The last look before a validation point is at the error that the point reports.
    firsts = [where for where in seen if where.step == result.history[0].step]
    assert firsts[-1].mean_abs_error == result.history[0].mean_abs_error


def test_ctrl_c_leaves_a_policy_of_what_was_learned(config: TrainConfig, tmp_path: Path) -> None:
    def interrupt(progress: TrainingProgress) -> None:
        if progress.step >= 900:
            raise KeyboardInterrupt

    result = train.train(config, tmp_path, progress=interrupt)
    assert result.interrupted
    assert names(tmp_path) == (FILES if result.history else WITHOUT_A_POINT)
    assert load_policy(result.policy_path).contract.provenance.scores["steps"] == result.steps


def test_divergence_is_said_and_not_exported(tmp_path: Path) -> None:
    literal = LearnerConfig(online=OnlineConfig(step="literal", alpha=1000.0))
    config = TrainConfig(steps=5000, network=NetworkConfig(output="linear"), learner=literal)
    with pytest.raises(UsageError, match="weights are not finite") as refusal:
        train.train(config, tmp_path)
    assert "\n" not in str(refusal.value)
    assert not (tmp_path / "policy.onnx").exists()


@pytest.mark.parametrize("name", ["online", "reflex"])
def test_short_run_learns_to_avoid_half_of_the_contacts(name: str, tmp_path: Path) -> None:
    validation = ValidationConfig(points=1, agents=64, steps=200)
    config = dataclasses.replace(preset_named(name), steps=200_000, validation=validation)
    result = train.train(config, tmp_path)
    assert result.history[-1].validation_contacts_per_100m < 0.5 * 36.0
