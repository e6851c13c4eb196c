"""The online learner in its world: its results, its report, its arrays."""

import dataclasses

import numpy as np
import pytest

from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_trainer.config.presets import PRESETS
from reflexarc_trainer.config.train_config import (
    ExplorationConfig,
    LearnerConfig,
    TrainConfig,
)
from reflexarc_trainer.policy.q_network import new_network
from reflexarc_trainer.policy.weights import pack
from reflexarc_trainer.sarsa.exploration import new_streams
from reflexarc_trainer.sarsa.online.learner import OnlineLearner
from reflexarc_trainer.sarsa.reference import learn
from support.precision import in_double


@pytest.mark.parametrize("action_repeat", [1, 3])
def test_compiled_learner_equals_the_reference_in_a_world(action_repeat: int) -> None:
    explore = ExplorationConfig(action_repeat=action_repeat)
    learner_config = LearnerConfig(exploration=explore, reward_centring=0.01)
    config = in_double(TrainConfig(steps=600, seed=11, learner=learner_config))
    learner = OnlineLearner(config)
    learner.run(config.steps)

    body = Simulation(config.goal_world, config.contract(), np.array([11], np.uint64))
    network = new_network(config.contract(), config.network, config.seed)
    list(learn(network, body, config.learner, new_streams(11), config.steps))
    np.testing.assert_allclose(learner.weights, pack(network), rtol=0, atol=1e-9)


def test_report_counts_every_contact_of_a_repeated_action() -> None:
    explore = ExplorationConfig(action_repeat=3, epsilon_start=1.0, epsilon_end=1.0)
    learner = OnlineLearner(TrainConfig(learner=LearnerConfig(exploration=explore)))
    learner.run(500)
    learner.mark()
    before = learner._simulation.contacts[0], learner._simulation.distance_m[0]
    learner.run(2000)
    contacts = learner._simulation.contacts[0] - before[0]
    distance_m = learner._simulation.distance_m[0] - before[1]
    assert contacts > 100
    assert learner.report().contacts_per_100m == pytest.approx(100.0 * contacts / distance_m)


def test_a_run_that_goes_on_from_its_arrays_has_the_same_bits() -> None:
    """With everything that the step by RMS, single precision and repeated actions keep."""
    config = dataclasses.replace(PRESETS["reflex-online"], steps=3000, seed=5)
    whole, first, second = (OnlineLearner(config) for _ in range(3))
    whole.run(3000)
    first.run(1237)
    second.restore({name: array.copy() for name, array in first.arrays().items()})
    second.run(3000 - 1237)
    for name, array in whole.arrays().items():
        np.testing.assert_array_equal(second.arrays()[name], array, err_msg=name)
