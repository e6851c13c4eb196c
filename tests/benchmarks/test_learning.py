"""The fair comparison is fair: everybody's world, policy and clock are what they should be."""

import json
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from learning_race.contenders import Theirs, named
from learning_race.field import FieldVecEnv
from learning_race.frozen import FrozenPolicy, of_ours, of_theirs
from learning_race.judge import FIRST_LOOK_S, Clock, Judge, Look, reached
from learning_race.learn import algorithm, new_model
from learning_race.report import write_report
from learning_race.results import Run, times_to
from learning_race.schedule import Scale, warm_entries

from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.files import world_named
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from reflexarc_sim_bridge.worlds.seeds import TRAINING_SEEDS
from reflexarc_trainer.config.presets import PRESETS
from reflexarc_trainer.policy.weights import NetworkPolicy, unpack
from reflexarc_trainer.sarsa.initial_weights import initial_weights

AGENTS, STEPS = 6, 120
STACK = reference_contract().retina.stack_shape


def random_retinas(count: int = 400) -> Any:
    return np.random.default_rng(1).integers(0, 256, (count, *STACK), np.uint8)


def policy_of(bias: float) -> FrozenPolicy:
    weights = np.zeros((16, 3), np.float32)
    return FrozenPolicy(((weights, np.array([bias, 0, 0], np.float32)),), "relu", 1)


def looks(*rates: float) -> list[Look]:
    return [Look(float(n), 100 * n, rate) for n, rate in enumerate(rates, 1)]


@pytest.mark.parametrize("held_steps", [1, 3])
def test_the_adapter_shows_and_pays_what_the_simulation_does(held_steps: int) -> None:
    env = FieldVecEnv(AGENTS, seed=2, input_power=2, held_steps=held_steps)
    numbers = 2 * AGENTS + np.arange(AGENTS)
    world, seeds = world_named("reference-1"), np.array(TRAINING_SEEDS, np.uint64)[numbers]
    simulation = Simulation(world, reference_contract(), seeds)
    shown, contacts = env.reset(), 0
    for actions in np.random.default_rng(0).integers(0, 3, (STEPS, AGENTS)):
        bytes_seen = simulation.sense().reshape(AGENTS, -1)
        np.testing.assert_allclose(shown, (bytes_seen / 255.0) ** 2, rtol=1e-6)
        met = [simulation.step(actions) for _ in range(held_steps)]
        shown, rewards, ended, _ = env.step(actions)
        np.testing.assert_allclose(rewards, np.where(met, -1.0, 0.1).sum(axis=0), rtol=1e-5)
        contacts += np.sum(met)
        assert not ended.any()
    assert contacts > 0


@pytest.mark.long
@pytest.mark.parametrize("name", ["PPO", "DQN", "QRDQN"])
@pytest.mark.parametrize("input_power", [1, 2])
def test_a_frozen_policy_decides_as_the_model_predicts(name: str, input_power: int) -> None:
    if name == "QRDQN":
        pytest.importorskip("sb3_contrib")
    settings = {} if name == "PPO" else {"buffer_size": 64}
    model = algorithm(name)("MlpPolicy", FieldVecEnv(2, seed=0), device="cpu", seed=3, **settings)
    for weights in model.policy.parameters():
        weights.data.normal_()  # fresh ones want the same everywhere
    retinas = random_retinas()
    shown = (retinas.reshape(len(retinas), -1) / 255.0).astype(np.float32) ** input_power
    wanted, _ = model.predict(shown, deterministic=True)
    _, actions = of_theirs(model, input_power).decide(retinas)
    np.testing.assert_array_equal(actions, wanted)
    assert len(set(actions.tolist())) > 1


@pytest.mark.parametrize("name", ["qrdqn-tuned", "dqn-matched"])
def test_a_rival_has_the_same_settings_after_its_model_is_made(name: str) -> None:
    """Its run would be said to be another one's, and be done again."""
    if name.startswith("qrdqn"):
        pytest.importorskip("sb3_contrib")
    contender = named(name)
    assert isinstance(contender.learner, Theirs)
    before = contender.settings_hash
    new_model(contender.learner, 0, Judge(Clock(), limit_s=1.0))
    assert contender.settings_hash == before


@pytest.mark.parametrize("preset", ["reflex", "online"])
def test_our_frozen_policy_decides_as_our_network(preset: str) -> None:
    config = replace(PRESETS[preset], seed=5)

    class Fresh:
        weights = initial_weights(config)

    Fresh.config = config  # type: ignore[attr-defined]  # what `of_ours` asks of a learner
    network = unpack(Fresh.weights, config.contract(), config.network)
    values, actions = of_ours(Fresh()).decide(random_retinas())  # type: ignore[arg-type]  # as above
    wanted_values, wanted = NetworkPolicy(network).decide(random_retinas())
    np.testing.assert_array_equal(actions, wanted)
    if config.network.output == "linear":
        np.testing.assert_allclose(values, wanted_values, atol=1e-5)


@pytest.mark.parametrize("written", ["", '{"seed"', "[]", '{"seed": 0}', "\x00"])
def test_a_spoiled_record_is_one_line_and_exit_status_2(
    written: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "reflex-3s-0.json").write_text(written)
    with pytest.raises(SystemExit) as ended:
        write_report(tmp_path)
    assert ended.value.code == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_a_level_counts_from_the_first_of_two_looks_in_a_row() -> None:
    seen = looks(7.0, 5.9, 6.1, 6.0, 5.0, 9.0)
    assert reached(seen, 6.0) == seen[3]
    assert reached(seen, 5.5) is None
    assert reached(seen[:2], 6.0) is None


def test_a_policy_that_has_learned_nothing_is_not_looked_at_again() -> None:
    judge = Judge(Clock(), limit_s=1e9, rate=lambda policy: 5.0)
    for bias in (0.0, 0.0, 1.0):
        judge.look(lambda bias=bias: policy_of(bias), 0)
    assert len(judge.looks) == 2


def test_after_a_cold_start_looks_follow_each_other_as_closely_as_after_a_warm_one() -> None:
    """Growing from the start of the process they would come seconds apart."""
    judge = Judge(Clock(time.monotonic() - 20.0), 60.0, rate=lambda policy: 5.0, starts_cold=True)
    judge.look(lambda: policy_of(0.0), 0)
    assert judge.due_s - judge.ended_s == pytest.approx(FIRST_LOOK_S)
    judge.look(lambda: policy_of(1.0), 0)
    assert judge.due_s - judge.looks[0].seconds < 2.0


def test_the_clock_stands_during_a_look() -> None:
    judge = Judge(Clock(), limit_s=1e9)
    judge.look(lambda: policy_of(0.0), 0)
    assert judge.looks[0].contacts_per_100m == pytest.approx(36.0, rel=0.1)
    assert judge.clock.seconds < 1e-2 + judge.looks[0].seconds


def test_a_level_that_too_few_seeds_reach_is_censored() -> None:
    good, bad = looks(5.0, 5.0, 5.0), looks(9.0, 9.0, 9.0)
    runs = [Run("x", "", seed, 60.0, 4.0, good if seed < 7 else bad) for seed in range(10)]
    assert times_to(runs, 6.0).is_censored
    assert not times_to(runs[:8], 6.0).is_censored
    assert times_to(runs, 6.0).seconds == [1.0] * 7 + [4.0] * 3


def test_a_report_is_made_of_what_there_is(tmp_path: Path) -> None:
    for entry in warm_entries([c for c in _some() if c.budget_s <= 60], seeds=4):
        record = {
            "contender": entry.contender.name,
            "settings": Scale().limited(entry.contender).settings_hash,
            "seed": entry.seed,
            "budget_s": entry.contender.budget_s,
            "seconds": 4.0,
            "looks": [[s.seconds, s.world_steps, s.contacts_per_100m] for s in looks(9, 5, 3, 3)],
            "test": [3.0 + 0.1 * entry.seed, 2.9, 3.1],
        }
        (tmp_path / f"{entry.name}.json").write_text(json.dumps(record))
    text = write_report(tmp_path)
    assert "| reflex-3s | ours | 4 | 2 [2, 2] | 3 [3, 3] | 3 [3, 3] |" in text
    assert "reflex-3s has 1 [" in text
    assert (tmp_path / "learning.png").read_bytes().startswith(b"\x89PNG")


def _some() -> Any:
    from learning_race.contenders import named

    return [named(name) for name in ("reflex-3s", "reflex-short", "ppo-tuned", "ppo-default")]
