"""The figure that a run watches is the one that the reference field measures."""

import dataclasses

import pytest

from reflexarc_sim_bridge.evaluation.reference_field import measure
from reflexarc_sim_bridge.worlds.seeds import validation_seeds
from reflexarc_trainer.config.presets import PRESETS, preset_named
from reflexarc_trainer.config.train_config import TrainConfig, TrainingWorld, ValidationConfig
from reflexarc_trainer.policy.q_network import new_network
from reflexarc_trainer.policy.weights import NetworkPolicy
from reflexarc_trainer.run.validation import drive_and_record, validate

EMPTY = TrainingWorld("empty", text='name = "empty"\nlayers = []\n')
SCALE = ValidationConfig(agents=32, steps=100, discard=10)


SHIFTING = [name for name, preset in PRESETS.items() if preset.motion == "sideways"]


@pytest.mark.parametrize("name", SHIFTING)
def test_validation_is_the_measurement_of_the_reference_field(name: str) -> None:
    config = dataclasses.replace(PRESETS[name], validation=SCALE)
    network = new_network(config.contract(), config.network, seed=2)
    score = measure(
        NetworkPolicy(network),
        config.contract(),
        agents=SCALE.agents,
        steps=SCALE.steps,
        discard=SCALE.discard,
        seeds=validation_seeds(SCALE.agents),
        world=config.goal_world,
    )
    assert validate(network, config) == pytest.approx(score.contacts_per_100m, rel=1e-12)


def test_recorded_retinas_are_what_a_driving_policy_meets() -> None:
    config = TrainConfig()
    network = new_network(config.contract(), config.network, seed=2)
    retinas = drive_and_record(network, config)
    assert retinas.shape == (8 * 64, 1, 1, 16, 1)
    assert len({row.tobytes() for row in retinas}) > 400


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
