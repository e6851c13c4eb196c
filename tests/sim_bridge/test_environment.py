import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from reflexarc_sim_bridge.environment import EPISODE_STEPS, REFERENCE_ID, ReferenceEnv
from reflexarc_sim_bridge.reference_field import reference_contract
from reflexarc_sim_bridge.simulation import Simulation
from reflexarc_sim_bridge.worlds import world_named


def test_gymnasium_s_own_checker_finds_nothing_to_say() -> None:
    check_env(gymnasium.make(REFERENCE_ID).unwrapped)


def test_it_sees_and_moves_as_the_simulation_does() -> None:
    environment = ReferenceEnv()
    observation, _ = environment.reset(seed=42)
    simulation = Simulation(
        world_named("reference-1"), reference_contract(), np.array([42], np.uint64)
    )
    for step in range(200):
        np.testing.assert_array_equal(observation, simulation.sense().reshape(-1))
        action = np.int64(step % 3)
        met = simulation.step(np.array([action]))[0]
        observation, reward, terminated, truncated, info = environment.step(action)
        assert reward == (-1.0 if met else 0.1)
        assert not terminated
        assert not truncated
        assert info["contacts"] == simulation.contacts[0]


def test_an_episode_ends_by_truncation_alone() -> None:
    environment = gymnasium.make(REFERENCE_ID)
    environment.reset(seed=0)
    ends = [environment.step(np.int64(0))[2:4] for _ in range(EPISODE_STEPS)]
    assert ends[-1] == (False, True)
    assert not any(any(end) for end in ends[:-1])


def test_episodes_without_a_seed_are_new_worlds_of_a_fixed_sequence() -> None:
    def worlds() -> list[bytes]:
        environment = ReferenceEnv()
        environment.reset(seed=5)
        return [environment.reset()[0].tobytes() for _ in range(4)]

    assert worlds() == worlds()
    assert len(set(worlds())) == 4


def test_a_step_before_a_reset_is_refused() -> None:
    with pytest.raises(gymnasium.error.ResetNeeded):
        ReferenceEnv().step(np.int64(0))
