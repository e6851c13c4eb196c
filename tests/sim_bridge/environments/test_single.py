import copy
import pickle
from collections.abc import Iterator

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env as gymnasium_check
from stable_baselines3.common.env_checker import check_env as stable_baselines_check

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.errors import WorldError
from reflexarc_sim_bridge.environments.episodes import EPISODE_STEPS
from reflexarc_sim_bridge.environments.registration import REFERENCE_ID, environment_id
from reflexarc_sim_bridge.environments.single import ReferenceEnv
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.files import WORLDS, world_named
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from reflexarc_sim_bridge.worlds.world import AfterContact, Chassis, World

LEFT = np.int64(1)
SHAPES = [
    RetinaSpec(rays=5),
    RetinaSpec(rays=7, frames=3),
    RetinaSpec(rays=4, channels=3),
    RetinaSpec(rays=6, eyes=2, baseline_m=0.1, frames=2, channels=3),
]
"""Plain, with a memory, in colour, and all at once with two eyes."""


@pytest.fixture
def field() -> Iterator[ReferenceEnv]:
    environment = ReferenceEnv()
    yield environment
    environment.close()


@pytest.mark.parametrize("name", WORLDS)
def test_gymnasium_s_own_checker_finds_nothing_to_say(name: str) -> None:
    gymnasium_check(gymnasium.make(environment_id(name)).unwrapped)


@pytest.mark.parametrize("name", WORLDS)
def test_stable_baselines_checker_finds_nothing_to_say(name: str) -> None:
    stable_baselines_check(gymnasium.make(environment_id(name)))


@pytest.mark.parametrize("retina", SHAPES, ids=lambda spec: "x".join(map(str, spec.stack_shape)))
def test_both_checkers_take_a_retina_of_any_form(retina: RetinaSpec) -> None:
    environment = gymnasium.make(REFERENCE_ID, contract=PolicyContract(retina)).unwrapped
    gymnasium_check(environment)
    stable_baselines_check(environment)


@pytest.mark.parametrize("retina", SHAPES, ids=lambda spec: "x".join(map(str, spec.stack_shape)))
def test_it_sees_and_moves_as_the_simulation_does(retina: RetinaSpec) -> None:
    contract = reference_contract(retina)
    environment = ReferenceEnv(contract)
    observation, info = environment.reset(seed=42)
    simulation = Simulation(world_named("reference-1"), contract, np.array([42], np.uint64))
    simulation.sense()
    for step in range(200):
        np.testing.assert_array_equal(observation.reshape(retina.stack_shape), simulation.stacks[0])
        assert info == told(simulation)
        action = np.int64(step // 7 % 3)
        met = simulation.step(np.array([action]))[0]
        simulation.sense()
        observation, reward, terminated, truncated, info = environment.step(action)
        assert reward == (-1.0 if met else 0.1)
        assert not terminated
        assert not truncated


def test_the_plain_eye_is_a_vector_of_its_rays(field: ReferenceEnv) -> None:
    assert field.observation_space == gymnasium.spaces.Box(0, 255, (16,), np.uint8)
    assert field.action_space == gymnasium.spaces.Discrete(3)


def test_an_episode_ends_by_truncation_alone() -> None:
    environment = gymnasium.make(REFERENCE_ID)
    environment.reset(seed=0)
    ends = [environment.step(np.int64(0))[2:4] for _ in range(EPISODE_STEPS)]
    assert ends[-1] == (False, True)
    assert not any(any(end) for end in ends[:-1])


def test_where_contacts_end_an_episode_they_alone_terminate_it() -> None:
    ends = World("ends", chassis=Chassis(after_contact=AfterContact.TERMINATE))
    environment = ReferenceEnv(world=ends)
    environment.reset(seed=0)
    for _ in range(300):
        _, reward, terminated, truncated, _ = environment.step(np.int64(0))
        assert terminated == (reward == -1.0)
        assert not truncated
        if terminated:
            return
    pytest.fail("300 steps straight ahead met nothing")


def test_a_seed_names_the_same_episode_whatever_came_before(field: ReferenceEnv) -> None:
    def episode() -> list[bytes]:
        first = field.reset(seed=9)[0].tobytes()
        return [first, *(field.step(LEFT)[0].tobytes() for _ in range(30))]

    fresh = episode()
    field.reset(seed=1)
    field.step(LEFT)
    assert episode() == fresh


def test_episodes_without_a_seed_are_new_worlds_of_a_fixed_sequence(field: ReferenceEnv) -> None:
    def worlds(seed: int) -> list[bytes]:
        field.reset(seed=seed)
        return [field.reset()[0].tobytes() for _ in range(4)]

    assert worlds(5) == worlds(5)
    assert len({*worlds(5), *worlds(6)}) == 8


def test_environments_that_were_never_seeded_meet_different_worlds() -> None:
    assert len({ReferenceEnv().reset()[0].tobytes() for _ in range(3)}) == 3


def test_what_was_seen_stays_as_it_was(field: ReferenceEnv) -> None:
    seen = [field.reset(seed=3)[0], *(field.step(LEFT)[0] for _ in range(5))]
    as_it_was = [observation.copy() for observation in seen]
    for _ in range(5):
        field.step(LEFT)
    field.reset()
    np.testing.assert_array_equal(seen, as_it_was)


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda env: pickle.loads(pickle.dumps(env))])
def test_a_copy_goes_on_by_itself(field: ReferenceEnv, copied: object) -> None:
    field.reset(seed=3)
    twin = copied(field)  # type: ignore[operator]  # one of the two functions above
    once = [field.step(LEFT)[0].tobytes() for _ in range(20)]
    assert [twin.step(LEFT)[0].tobytes() for _ in range(20)] == once


def test_a_copy_of_one_that_has_not_begun_has_not_begun(field: ReferenceEnv) -> None:
    with pytest.raises(gymnasium.error.ResetNeeded):
        copy.deepcopy(field).step(LEFT)


def test_a_step_before_a_reset_is_refused(field: ReferenceEnv) -> None:
    with pytest.raises(gymnasium.error.ResetNeeded):
        field.step(np.int64(0))


@pytest.mark.parametrize("action", [-1, 3, 1 << 40])
def test_an_action_that_there_is_not_is_refused_and_moves_nothing(
    field: ReferenceEnv, action: int
) -> None:
    field.reset(seed=3)
    with pytest.raises(WorldError, match=f"expected 0 to 2, .* got {action}"):
        field.step(np.int64(action))
    assert field.step(LEFT)[4]["x_m"] == pytest.approx(0.1)


def test_an_action_that_is_no_integer_is_refused(field: ReferenceEnv) -> None:
    field.reset(seed=3)
    with pytest.raises(TypeError):
        field.step(1.5)  # type: ignore[arg-type]  # on purpose


@pytest.mark.parametrize("seed", [1 << 64, 1 << 70])
def test_a_seed_of_no_world_is_refused(field: ReferenceEnv, seed: int) -> None:
    with pytest.raises(WorldError, match="seed: expected 0 to"):
        field.reset(seed=seed)


def test_a_world_that_there_is_not_is_refused() -> None:
    with pytest.raises(WorldError, match="no world is named 'mars'"):
        ReferenceEnv(world="mars")


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("reference-1", "reflexarc/Reference-v1"),
        ("reference-2", "reflexarc/Reference-v2"),
        ("discs", "reflexarc/Discs-v1"),
        ("corridor-10", "reflexarc/Corridor10-v1"),
    ],
)
def test_a_world_s_name_is_its_environment_s_but_for_the_reference_s_number(
    name: str, expected: str
) -> None:
    assert environment_id(name) == expected


def told(simulation: Simulation) -> dict[str, float]:
    names = ("x_m", "y_m", "distance_m", "contacts")
    return {name: getattr(simulation, name)[0] for name in names}


@pytest.mark.parametrize("action", [-1, 3, 1 << 62, 1 << 70, -(1 << 70)])
def test_an_action_that_the_contract_does_not_have_is_refused(action: int) -> None:
    environment = ReferenceEnv()
    environment.reset(seed=0)
    with pytest.raises(WorldError, match=f"action: expected 0 to 2, the contract's, got {action}"):
        environment.step(action)
