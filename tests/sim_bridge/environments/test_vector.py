from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv, VectorEnv

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.errors import WorldError
from reflexarc_sim_bridge.environments.episodes import EPISODE_STEPS
from reflexarc_sim_bridge.environments.registration import REFERENCE_ID, environment_id
from reflexarc_sim_bridge.environments.single import ReferenceEnv
from reflexarc_sim_bridge.environments.vector import ReferenceVectorEnv
from reflexarc_sim_bridge.worlds.files import WORLDS
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from reflexarc_sim_bridge.worlds.seeds import test_seeds as reported_seeds
from reflexarc_sim_bridge.worlds.world import AfterContact, Chassis, World

AGENTS = 5
EPISODE = 12
TURNS = (Action("on", 1.0, 0.0), Action("left", 0.5, 0.0, 0.8), Action("right", 0.5, 0.2, -0.8))
ENDS = World("ends", chassis=Chassis(after_contact=AfterContact.TERMINATE), width_m=10.0)
MEMORY = reference_contract(RetinaSpec(rays=5, frames=3))
"""Shows a look too many or too few."""
INFOS = {"x_m", "y_m", "distance_m", "contacts"}
SEEDED = np.arange(AGENTS, dtype=np.int64)
"""An action each is not all the same: 0, 1, 2, 0, 1."""


@pytest.fixture
def envs() -> ReferenceVectorEnv:
    return ReferenceVectorEnv(AGENTS, max_episode_steps=EPISODE)


def actions_of(step: int) -> np.ndarray[Any, np.dtype[np.int64]]:
    return (SEEDED + step // 4) % 3


def singles(make: Callable[[], gymnasium.Env[Any, Any]], count: int = AGENTS) -> SyncVectorEnv:
    return SyncVectorEnv([make] * count)


def limited(**kwargs: Any) -> gymnasium.Env[Any, Any]:
    return gymnasium.wrappers.TimeLimit(ReferenceEnv(**kwargs), EPISODE)


def assert_same_step(one: Any, other: Any) -> None:
    for a, b in zip(one[:-1], other[:-1], strict=True):
        np.testing.assert_array_equal(a, b)
        assert a.dtype == b.dtype
    for name in INFOS:
        np.testing.assert_array_equal(one[-1][name], other[-1][name])


def assert_same_run(one: VectorEnv[Any, Any, Any], other: Any, steps: int = 4 * EPISODE) -> None:
    for step in range(steps):
        assert_same_step(one.step(actions_of(step)), other.step(actions_of(step)))


# Agreement with single environments -------------------------------------------------------------


@pytest.mark.parametrize(
    "contract",
    [
        reference_contract(),
        reference_contract(RetinaSpec(rays=5, eyes=2, frames=3, channels=3)),
        PolicyContract(actions=TURNS),
    ],
    ids=["plain", "with two eyes and a memory", "turning"],
)
def test_many_agents_meet_what_as_many_single_environments_meet(contract: PolicyContract) -> None:
    envs = ReferenceVectorEnv(AGENTS, contract, max_episode_steps=EPISODE)
    others = singles(lambda: limited(contract=contract))
    assert_same_step(envs.reset(seed=70), others.reset(seed=70))
    assert_same_run(envs, others)


@pytest.mark.parametrize("name", WORLDS)
def test_they_do_in_every_world(name: str) -> None:
    envs = ReferenceVectorEnv(AGENTS, world=name, max_episode_steps=EPISODE)
    others = singles(lambda: limited(world=name))
    assert_same_step(envs.reset(seed=3), others.reset(seed=3))
    assert_same_run(envs, others)


def test_they_do_where_contacts_end_episodes() -> None:
    envs = ReferenceVectorEnv(AGENTS, MEMORY, ENDS, max_episode_steps=EPISODE)
    others = singles(lambda: limited(contract=MEMORY, world=ENDS))
    assert_same_step(envs.reset(seed=3), others.reset(seed=3))
    assert_same_run(envs, others, 10 * EPISODE)


def test_they_do_with_a_seed_each_even_the_same_one(envs: ReferenceVectorEnv) -> None:
    others = singles(limited)
    seeds: list[int | None] = [8, 8, 1, int(reported_seeds(1)[0]), 0]
    assert_same_step(envs.reset(seed=seeds), others.reset(seed=seeds))
    assert_same_run(envs, others)


def test_they_do_when_some_begin_anew() -> None:
    envs = ReferenceVectorEnv(AGENTS, MEMORY, max_episode_steps=EPISODE)
    others = singles(lambda: limited(contract=MEMORY))
    mask = np.array([True, False, False, True, False])
    assert_same_step(envs.reset(seed=1), others.reset(seed=1))
    assert_same_run(envs, others, 5)
    one = envs.reset(options={"reset_mask": mask})
    np.testing.assert_array_equal(one[0], others.reset(options={"reset_mask": mask.copy()})[0])
    assert_same_run(envs, others)


def test_they_do_when_some_begin_anew_with_seeds(envs: ReferenceVectorEnv) -> None:
    others, mask = singles(limited), np.array([False, True, True, False, False])
    seeds: list[int | None] = [None, 31, None, 5, None]
    assert_same_step(envs.reset(seed=1), others.reset(seed=1))
    assert_same_run(envs, others, EPISODE)  # all have just ended
    one = envs.reset(seed=seeds, options={"reset_mask": mask})
    other = others.reset(seed=seeds, options={"reset_mask": mask.copy()})
    np.testing.assert_array_equal(one[0], other[0])
    assert_same_run(envs, others)


# Worlds and seeds -------------------------------------------------------------------------------


def test_a_seed_names_the_same_run_whatever_came_before(envs: ReferenceVectorEnv) -> None:
    def run() -> list[bytes]:
        first = envs.reset(seed=4)[0].tobytes()
        return [first, *(envs.step(actions_of(step))[0].tobytes() for step in range(30))]

    fresh = run()
    envs.reset(seed=9)
    envs.step(actions_of(0))
    assert run() == fresh


def test_a_reset_without_a_seed_goes_on_to_new_worlds(envs: ReferenceVectorEnv) -> None:
    seen = [envs.reset(seed=4)[0], envs.reset()[0], envs.reset()[0]]
    assert len({row.tobytes() for rows in seen for row in rows}) == 3 * AGENTS


def test_environments_that_were_never_seeded_meet_different_worlds() -> None:
    one, other = ReferenceVectorEnv(AGENTS).reset()[0], ReferenceVectorEnv(AGENTS).reset()[0]
    assert len({row.tobytes() for row in (*one, *other)}) == 2 * AGENTS


@pytest.mark.parametrize("seed", [[1, 2], [1] * (AGENTS + 1), (1 << 64) - 1, [1 << 64] * AGENTS])
def test_seeds_of_another_number_or_of_no_world_are_refused(
    envs: ReferenceVectorEnv, seed: Any
) -> None:
    with pytest.raises(WorldError, match="seed: expected"):
        envs.reset(seed=seed)


# Episodes ---------------------------------------------------------------------------------------


def test_the_step_after_an_episode_s_last_begins_the_next_one(envs: ReferenceVectorEnv) -> None:
    envs.reset(seed=2)
    for _ in range(EPISODE - 1):
        _, _, terminated, truncated, infos = envs.step(SEEDED % 3)
        assert not terminated.any()
        assert not truncated.any()
    last = envs.step(SEEDED % 3)
    assert last[3].all()
    assert (last[4]["distance_m"] > 1.0).all()
    _, rewards, terminated, truncated, infos = envs.step(SEEDED % 3)
    assert (rewards == 0.0).all()
    assert not terminated.any()
    assert not truncated.any()
    for name in ("x_m", "distance_m", "contacts"):
        assert (infos[name] == 0).all()


def test_every_episode_is_as_long_as_the_first(envs: ReferenceVectorEnv) -> None:
    envs.reset(seed=2)
    truncated = [envs.step(SEEDED % 3)[3].all() for _ in range(3 * (EPISODE + 1))]
    assert np.flatnonzero(truncated).tolist() == [
        EPISODE - 1,
        2 * EPISODE,
        3 * EPISODE + 1,
    ]


def test_agents_begin_anew_each_at_its_own_time(envs: ReferenceVectorEnv) -> None:
    mask = np.arange(AGENTS) % 2 == 0
    envs.reset(seed=2)
    for _ in range(5):
        envs.step(SEEDED % 3)
    envs.reset(options={"reset_mask": mask})
    ends = np.array([envs.step(SEEDED % 3)[3] for _ in range(EPISODE)])
    assert (ends.argmax(axis=0) == np.where(mask, EPISODE - 1, EPISODE - 6)).all()


def test_a_reset_forgets_that_an_episode_had_ended(envs: ReferenceVectorEnv) -> None:
    envs.reset(seed=2)
    for _ in range(EPISODE):
        envs.step(SEEDED % 3)
    envs.reset(seed=2)
    _, rewards, _, _, infos = envs.step(SEEDED % 3)
    assert (rewards != 0.0).all()
    assert (infos["x_m"] > 0.0).all()


def test_without_a_limit_nothing_is_truncated() -> None:
    envs = ReferenceVectorEnv(2, max_episode_steps=None)
    envs.reset(seed=2)
    ends = [envs.step(np.zeros(2, np.int64))[3].any() for _ in range(EPISODE_STEPS + 5)]
    assert not any(ends)


def test_contacts_are_rewarded_and_end_nothing() -> None:
    envs = ReferenceVectorEnv(64)
    contacts = envs.reset(seed=2)[1]["contacts"]
    for _ in range(50):
        _, rewards, terminated, truncated, infos = envs.step(np.zeros(64, np.int64))
        np.testing.assert_array_equal(rewards == -1.0, infos["contacts"] == contacts + 1)
        np.testing.assert_array_equal(rewards == 0.1, infos["contacts"] == contacts)
        assert not terminated.any()
        assert not truncated.any()
        contacts = infos["contacts"]
    assert contacts.sum() > 64


def test_where_contacts_end_episodes_termination_and_truncation_are_told_apart() -> None:
    envs = ReferenceVectorEnv(64, world=ENDS, max_episode_steps=EPISODE)
    envs.reset(seed=3)
    steps, terminations, truncations = np.zeros(64, np.int64), 0, 0
    for _ in range(5 * EPISODE):
        _, rewards, terminated, truncated, _ = envs.step(np.zeros(64, np.int64))
        steps = np.where(rewards == 0.0, 0, steps + 1)
        np.testing.assert_array_equal(terminated, rewards == -1.0)
        np.testing.assert_array_equal(truncated, steps == EPISODE)
        terminations, truncations = terminations + terminated.sum(), truncations + truncated.sum()
        steps[terminated | truncated] = -1  # the next step is none, it begins anew
    assert terminations > 20
    assert truncations > 20


# Partial resets ---------------------------------------------------------------------------------


def test_a_mask_leaves_all_others_as_they_were() -> None:
    envs = ReferenceVectorEnv(AGENTS, MEMORY)
    envs.reset(seed=1)
    before, _, _, _, infos = [envs.step(actions_of(step)) for step in range(6)][-1]
    mask = np.array([False, True, False, False, True])
    after, told = envs.reset(options={"reset_mask": mask})
    np.testing.assert_array_equal(before[~mask], after[~mask])
    np.testing.assert_array_equal(infos["x_m"][~mask], told["x_m"][~mask])
    assert (told["x_m"][mask] == 0.0).all()
    assert (after[mask] != before[mask]).any(axis=1).all()


@pytest.mark.parametrize(
    "mask", [[True] * AGENTS, np.ones(AGENTS), np.ones(3, bool), np.zeros(AGENTS, bool)]
)
def test_what_is_no_mask_of_agents_is_refused(envs: ReferenceVectorEnv, mask: Any) -> None:
    envs.reset(seed=1)
    with pytest.raises(WorldError, match="reset_mask: expected bool \\(5,\\)"):
        envs.reset(options={"reset_mask": mask})


def test_the_caller_s_options_are_not_touched(envs: ReferenceVectorEnv) -> None:
    options = {"reset_mask": np.ones(AGENTS, np.bool_)}
    envs.reset(seed=1)
    envs.reset(options=options)
    assert list(options) == ["reset_mask"]


# Form -------------------------------------------------------------------------------------------


def test_the_spaces_are_those_of_one_agent_times_many(envs: ReferenceVectorEnv) -> None:
    one = ReferenceEnv()
    assert envs.single_observation_space == one.observation_space
    assert envs.single_action_space == one.action_space
    assert envs.observation_space == gymnasium.spaces.Box(0, 255, (AGENTS, 16), np.uint8)
    assert envs.action_space == gymnasium.spaces.MultiDiscrete([3] * AGENTS)
    assert envs.metadata["autoreset_mode"] is AutoresetMode.NEXT_STEP


def test_what_is_returned_lies_in_the_spaces(envs: ReferenceVectorEnv) -> None:
    observations, _ = envs.reset(seed=1)
    assert observations in envs.observation_space
    observations, rewards, terminated, truncated, infos = envs.step(envs.action_space.sample())
    assert observations in envs.observation_space
    assert rewards.dtype == np.float64
    assert rewards.shape == (AGENTS,)
    assert terminated.dtype == truncated.dtype == np.bool_
    assert terminated.shape == truncated.shape == (AGENTS,)
    assert set(infos) == INFOS
    assert all(values.shape == (AGENTS,) for values in infos.values())


def test_what_was_returned_stays_as_it_was(envs: ReferenceVectorEnv) -> None:
    kept: list[Any] = []
    observations, infos = envs.reset(seed=3)
    kept += [observations, *infos.values()]
    for step in range(2 * EPISODE):
        *arrays, infos = envs.step(actions_of(step))
        kept += [*arrays, *infos.values()]
    as_it_was = [array.copy() for array in kept]
    for array in kept[-8:]:
        array[...] = 1  # the caller's own, so this changes nothing of ours
    twin = ReferenceVectorEnv(AGENTS, max_episode_steps=EPISODE)
    twin.reset(seed=3)
    for step in range(2 * EPISODE):
        twin.step(actions_of(step))
    assert_same_run(envs, twin)
    envs.reset(seed=4)
    for array, was in zip(kept[:-8], as_it_was[:-8], strict=True):
        np.testing.assert_array_equal(array, was)


@pytest.mark.parametrize("kind", [np.int32, np.uint8, list])
def test_integers_of_any_kind_are_actions(envs: ReferenceVectorEnv, kind: Any) -> None:
    envs.reset(seed=1)
    as_given = [2, 1, 0, 1, 2]
    given = as_given if kind is list else np.array(as_given, kind)
    seen = envs.step(given)[0]  # type: ignore[arg-type]  # one of three kinds
    envs.reset(seed=1)
    np.testing.assert_array_equal(seen, envs.step(np.array(as_given))[0])


@pytest.mark.parametrize("actions", [[0.0] * AGENTS, [0] * 4, [3] + [0] * 4, [-1] + [0] * 4])
def test_what_is_no_action_is_refused(envs: ReferenceVectorEnv, actions: Any) -> None:
    envs.reset(seed=1)
    with pytest.raises(WorldError, match="actions: expected"):
        envs.step(np.array(actions))


@pytest.mark.parametrize("arguments", [{"num_envs": 0}, {"max_episode_steps": 0}])
def test_numbers_without_a_meaning_are_refused(arguments: dict[str, Any]) -> None:
    with pytest.raises(WorldError, match=f"{next(iter(arguments))}: expected 1 or more"):
        ReferenceVectorEnv(**arguments)


def test_a_step_or_a_mask_before_a_reset_is_refused(envs: ReferenceVectorEnv) -> None:
    with pytest.raises(gymnasium.error.ResetNeeded):
        envs.step(SEEDED % 3)
    with pytest.raises(gymnasium.error.ResetNeeded):
        envs.reset(options={"reset_mask": np.ones(AGENTS, np.bool_)})


def test_a_closed_environment_does_nothing_more(envs: ReferenceVectorEnv) -> None:
    envs.reset(seed=1)
    envs.close()
    envs.close()
    with pytest.raises(gymnasium.error.ClosedEnvironmentError):
        envs.step(SEEDED % 3)
    with pytest.raises(gymnasium.error.ClosedEnvironmentError):
        envs.reset()


# By name ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", WORLDS)
def test_gymnasium_makes_it_by_name_for_every_world(name: str) -> None:
    envs = gymnasium.make_vec(environment_id(name), num_envs=2)
    assert isinstance(envs.unwrapped, ReferenceVectorEnv)
    twin = ReferenceVectorEnv(2, world=name, max_episode_steps=EPISODE_STEPS)
    np.testing.assert_array_equal(envs.reset(seed=1)[0], twin.reset(seed=1)[0])


def test_gymnasium_s_limit_of_steps_is_heeded() -> None:
    envs = gymnasium.make_vec(REFERENCE_ID, num_envs=2, max_episode_steps=3)
    envs.reset(seed=1)
    ends = [envs.step(np.zeros(2, np.int64))[3].all() for _ in range(3)]
    assert ends == [False, False, True]


def test_gymnasium_s_own_wrappers_fit() -> None:
    envs = gymnasium.wrappers.vector.RecordEpisodeStatistics(
        ReferenceVectorEnv(AGENTS, max_episode_steps=EPISODE)
    )
    envs.reset(seed=1)
    total = sum(envs.step(actions_of(step))[1] for step in range(EPISODE - 1))
    _, rewards, _, _, infos = envs.step(actions_of(EPISODE - 1))
    np.testing.assert_allclose(infos["episode"]["r"], total + rewards)
    assert (infos["episode"]["l"] == EPISODE).all()
