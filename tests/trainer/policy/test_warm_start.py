"""Weights out of a policy file: exactly those, or a refusal."""

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.errors import PolicyError, UsageError
from reflexarc_runtime.policy.policy import load_policy
from reflexarc_trainer.config.train_config import NetworkConfig, TrainConfig
from reflexarc_trainer.policy.export import export
from reflexarc_trainer.policy.q_network import new_network
from reflexarc_trainer.policy.warm_start import weights_of
from reflexarc_trainer.policy.weights import pack
from reflexarc_trainer.run import train
from reflexarc_trainer.sarsa.forms import new_learner

NETWORK = NetworkConfig(hidden=(8,), units="relu", output="linear", input_power=2)


def exported(config: TrainConfig, path: Path) -> Path:
    export(new_network(config.contract(), config.network, seed=5), config.contract(), path)
    return path


@pytest.mark.parametrize(
    "network", [NetworkConfig(), NETWORK, NetworkConfig(hidden=(8, 4), units="tanh")]
)
def test_weights_come_back_exactly_as_float32(network: NetworkConfig, tmp_path: Path) -> None:
    learner = dataclasses.replace(TrainConfig().learner, form="batched")
    config = TrainConfig(network=network, learner=learner)
    weights, name = weights_of(exported(config, tmp_path / "p.onnx"), config)
    expected = pack(new_network(config.contract(), network, seed=5)).astype(np.float32)
    assert np.array_equal(weights, expected.astype(np.float64))
    assert name == load_policy(tmp_path / "p.onnx").policy_hash


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"retina": RetinaSpec(rays=8)}, "expected an eye of 1 x 1 x 8 x 1 values, got"),
        ({"network": NetworkConfig(hidden=(9,))}, "expected a network of 9 hidden units"),
        ({"network": dataclasses.replace(NETWORK, units="tanh")}, "its Q-values differ"),
        ({"network": dataclasses.replace(NETWORK, input_power=1)}, "its Q-values differ"),
        ({"network": dataclasses.replace(NETWORK, output="sigmoid")}, "its Q-values differ"),
    ],
)
def test_policy_of_another_eye_or_network_is_refused_in_one_line(
    change: dict[str, Any], said: str, tmp_path: Path
) -> None:
    path = exported(TrainConfig(network=NETWORK), tmp_path / "p.onnx")
    config = dataclasses.replace(TrainConfig(network=NETWORK), **change)
    with pytest.raises(UsageError, match=said) as refusal:
        weights_of(path, config)
    assert "\n" not in str(refusal.value)
    assert "p.onnx" in str(refusal.value)


def test_what_is_no_policy_is_refused(tmp_path: Path) -> None:
    (tmp_path / "p.onnx").write_bytes(b"weights")
    with pytest.raises(PolicyError, match=r"p\.onnx"):
        weights_of(tmp_path / "p.onnx", TrainConfig())


@pytest.mark.parametrize("form", ["online", "batched"])
def test_learner_begins_with_the_given_weights(
    form: str, small_config: TrainConfig, small_batched_config: TrainConfig
) -> None:
    config = small_config if form == "online" else small_batched_config
    weights = pack(new_network(config.contract(), config.network, seed=99)).astype(np.float32)
    learner = new_learner(config, weights.astype(np.float64))
    assert np.array_equal(learner.weights, weights)


def test_run_names_the_policy_that_it_began_with_and_resumes(
    small_batched_config: TrainConfig, tmp_path: Path
) -> None:
    config = small_batched_config
    source = exported(config, tmp_path / "p.onnx")
    whole = train.train(config, tmp_path / "whole", init_from=source)
    broken = train.train(config, tmp_path / "broken", init_from=source, should_stop=lambda: True)
    assert broken.steps == 0
    retinas = np.random.default_rng(1).integers(0, 256, (9, 1, 1, 16, 1), np.uint8)
    values = [load_policy(p).decide(retinas)[0] for p in (source, broken.policy_path)]
    assert values[0].tobytes() == values[1].tobytes()
    source.unlink()
    mended = train.resume(tmp_path / "broken")
    assert mended.policy_path.read_bytes() == whole.policy_path.read_bytes()
    provenance = load_policy(whole.policy_path).contract.provenance
    assert len(provenance.config["init_from"]) == 64
    assert provenance.config_hash != config.hash
