"""One unit of a study is what training and evaluating by hand give."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec, Shading
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.policy.policy import load_policy
from reflexarc_sim_bridge.evaluation.protocol.contender import Contender
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import Suite
from reflexarc_sim_bridge.evaluation.reference_field import DISCARDED_STEPS
from reflexarc_sim_bridge.evaluation.reference_field import measure as measure_policy
from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy
from reflexarc_trainer.config.train_config import (
    LearnerConfig,
    OnlineConfig,
    TrainConfig,
    TrainingWorld,
)
from reflexarc_trainer.policy.weights import network_of
from reflexarc_trainer.run import checkpoint
from reflexarc_trainer.run.train import train
from reflexarc_trainer.run.validation import GreedyPolicy
from reflexarc_trainer.sarsa.forms import new_learner
from reflexarc_trainer.study.definition import parse_study
from reflexarc_trainer.study.measuring import measure
from reflexarc_trainer.study.unit import Evaluation, Measure, Unit

SCALE = Evaluation(agents=16, steps=60, discard=5)


@pytest.mark.parametrize("form", ["online", "batched"])
def test_unit_learns_what_train_learns_and_scores_what_evaluate_says(
    form: str, small_config: TrainConfig, small_batched_config: TrainConfig, tmp_path: Path
) -> None:
    config = small_config if form == "online" else small_batched_config
    result = measure(Unit(config, SCALE))
    run = train(config, tmp_path)
    learned = checkpoint.load(tmp_path / "checkpoint.npz").learner()
    policy = load_policy(run.policy_path)
    scale = {"agents": 16, "steps": 60, "discard": 5}
    score = measure_policy(policy, policy.contract, **scale)
    blind = measure_policy(BlindPolicy(), policy.contract, **scale)
    assert result.steps == learned.step == run.steps
    assert result.contacts_per_100m == pytest.approx(score.contacts_per_100m, rel=1e-12)
    share = score.contacts_per_100m / blind.contacts_per_100m
    assert result.share_of_blind == pytest.approx(share, rel=1e-12)
    assert (result.diverged, result.edge_index) == (False, None)


def test_same_unit_gives_the_same_figures(small_config: TrainConfig) -> None:
    first, second = (measure(Unit(small_config, SCALE)) for _ in range(2))
    times = {"learning_s": 0.0, "evaluation_s": 0.0}
    assert dataclasses.replace(first, **times) == dataclasses.replace(second, **times)
    other = measure(Unit(dataclasses.replace(small_config, seed=4), SCALE))
    assert other.weights_hash != first.weights_hash


def test_run_that_diverges_is_a_result(small_config: TrainConfig) -> None:
    step = OnlineConfig(step="literal", alpha=1000.0)
    network = dataclasses.replace(small_config.network, output="linear", units="relu")
    config = dataclasses.replace(small_config, network=network, learner=LearnerConfig(online=step))
    result = measure(Unit(config, SCALE))
    assert result.diverged
    assert result.contacts_per_100m is None
    assert result.figure(Measure.CONTACTS) is None


def test_unit_becomes_plain_json_and_comes_back(small_batched_config: TrainConfig) -> None:
    unit = Unit(small_batched_config, Evaluation(agents=3, world="legacy"), Measure.EDGE_INDEX)
    back = Unit.from_plain(json.loads(json.dumps(unit.to_plain())))
    assert back == unit
    assert back.hash == unit.hash
    assert unit.world == TrainingWorld("legacy")
    with pytest.raises(UsageError, match="not one of this version"):
        Unit.from_plain({"config": {}})


def test_hash_covers_configuration_scale_measure_and_the_text_of_the_world(
    small_config: TrainConfig,
) -> None:
    unit = Unit(small_config, SCALE)
    units = [
        unit,
        Unit(dataclasses.replace(small_config, seed=9), SCALE),
        Unit(small_config, dataclasses.replace(SCALE, steps=61)),
        Unit(small_config, SCALE, Measure.EDGE_INDEX),
        Unit(small_config, dataclasses.replace(SCALE, world="tier-05")),
        Unit(small_config, SCALE, world=TrainingWorld("reference-1", text='name = "x"')),
    ]
    assert len({unit.hash for unit in units}) == len(units)


def test_measured_elsewhere_than_learned(small_config: TrainConfig) -> None:
    here = measure(Unit(small_config, SCALE))
    there = measure(Unit(small_config, dataclasses.replace(SCALE, world="tier-05")))
    assert here.weights_hash == there.weights_hash
    assert there.contacts_per_100m != here.contacts_per_100m


def test_blind_agents_contacts_do_not_depend_on_its_eye() -> None:
    eyes = (
        RetinaSpec(),
        RetinaSpec(rays=8, eyes=2, baseline_m=0.1, fov_rad=1.5),
        RetinaSpec(rays=16, range_m=1.5, shading=Shading.COLOUR),
    )
    scores = [
        measure_policy(BlindPolicy(), PolicyContract(retina=eye), agents=64, steps=100)
        for eye in eyes
    ]
    assert len({(score.contacts, score.distance_m) for score in scores}) == 1


def test_a_world_without_obstacles_has_no_share_of_blind(small_config: TrainConfig) -> None:
    empty = TrainingWorld("empty", text='name = "empty"\nlayers = []\n')
    result = measure(Unit(dataclasses.replace(small_config, worlds=(empty,)), SCALE))
    assert (result.contacts_per_100m, result.share_of_blind) == (0.0, None)


def test_edge_index_is_measured_where_it_is_asked_for(small_config: TrainConfig) -> None:
    result = measure(Unit(small_config, SCALE, Measure.EDGE_INDEX))
    assert result.figure(Measure.EDGE_INDEX) == result.edge_index
    assert result.edge_index is not None
    assert 0.0 <= result.edge_index <= 20.0 / 1.8
    assert np.isfinite(result.edge_index)


def test_as_many_steps_are_discarded_as_in_the_reference_field() -> None:
    assert Evaluation().discard == DISCARDED_STEPS


def test_a_cell_may_be_measured_where_it_did_not_learn(small_batched_config: TrainConfig) -> None:
    """The policy is that of the straight eye; what it meets askew is measured here by hand."""
    text = f"""
    title = "T"
    question = "Q?"
    seeds = [3]
    [evaluation]
    agents = {SCALE.agents}
    steps = {SCALE.steps}
    discard = {SCALE.discard}
    [[cell]]
    name = "straight"
    [[cell]]
    name = "askew"
    measured_in = "askew-90"
    """
    study, config = parse_study(text, "mine"), small_batched_config
    here, there = (Unit(config, study.unit(cell, 3).evaluation) for cell in study.cells)
    straight, askew = measure(here), measure(there)
    assert (here.world, there.world) == (TrainingWorld(), TrainingWorld("askew-90"))
    assert straight.weights_hash == askew.weights_hash
    learner = new_learner(config)
    learner.run(config.steps)
    policy = GreedyPolicy(network_of(learner), config)
    world = config.source_of(TrainingWorld("askew-90"))
    scale = {"agents": SCALE.agents, "steps": SCALE.steps, "discard": SCALE.discard}
    score = measure_policy(policy, config.contract(), world=world, **scale)
    assert askew.contacts_per_100m == score.contacts_per_100m
    assert askew.contacts_per_100m != straight.contacts_per_100m
    assert askew.blind_per_100m == straight.blind_per_100m  # its eye does not matter


def test_a_broader_body_meets_more_and_so_does_one_that_never_steers(
    small_config: TrainConfig,
) -> None:
    broad = dataclasses.replace(small_config, worlds=(TrainingWorld("broad"),))
    result = measure(Unit(broad, Evaluation(agents=256, steps=300)))
    expected = 100.0 * 0.40 * (0.9 + 2 * 0.2)  # 2ρR; round corners are met a little more often
    assert result.blind_per_100m is not None
    assert expected < result.blind_per_100m < 1.08 * expected


def test_the_suites_score_is_measured_where_it_is_asked_for(
    small_config: TrainConfig, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = list[tuple[str, Setting]]()

    def headline(contender: Contender, suite: Suite, setting: Setting) -> float:
        asked.append((suite.name, setting))
        assert isinstance(contender.policy, GreedyPolicy)
        assert contender.contract == small_config.contract()
        return 0.25

    monkeypatch.setattr("reflexarc_trainer.study.measuring.headline", headline)
    assert measure(Unit(small_config, SCALE)).suite_score is None
    assert measure(Unit(small_config, SCALE, Measure.SUITE)).figure(Measure.SUITE) == 0.25
    assert asked == [("lite", Setting.FIELD)]
