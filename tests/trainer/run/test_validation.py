"""The figure that a run watches is the one that the reference field measures."""

import dataclasses

import pytest

from reflexarc_sim_bridge.evaluation.reference_field import measure
from reflexarc_sim_bridge.worlds.seeds import validation_seeds
from reflexarc_trainer.config.presets import PRESETS
from reflexarc_trainer.config.train_config import TrainConfig, ValidationConfig
from reflexarc_trainer.policy.q_network import new_network
from reflexarc_trainer.policy.weights import NetworkPolicy
from reflexarc_trainer.run.validation import drive_and_record, validate

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
