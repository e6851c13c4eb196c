"""Checkpoints: what they export, and what is refused."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from reflexarc_runtime.errors import UsageError
from reflexarc_trainer.config.train_config import (
    NetworkConfig,
    TrainConfig,
)
from reflexarc_trainer.run import train
from reflexarc_trainer.run.delivery import export_checkpoint
from reflexarc_trainer.sarsa.forms import new_learner


def test_checkpoint_exports_the_same_policy(whole_run: train.TrainResult, tmp_path: Path) -> None:
    source = whole_run.policy_path.parent / "checkpoint.npz"
    export_checkpoint(source, tmp_path / "again.onnx")
    assert (tmp_path / "again.onnx").read_bytes() == whole_run.policy_path.read_bytes()


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 torn", b"weights"])
def test_file_that_is_no_checkpoint_is_refused_in_one_line(content: bytes, tmp_path: Path) -> None:
    (tmp_path / "checkpoint.npz").write_bytes(content)
    with pytest.raises(UsageError, match=r"checkpoint\.npz: expected a checkpoint") as refusal:
        train.resume(tmp_path)
    assert "\n" not in str(refusal.value)


def test_checkpoint_of_another_format_is_refused_in_one_line(
    whole_run: train.TrainResult, tmp_path: Path
) -> None:
    with np.load(whole_run.policy_path.parent / "checkpoint.npz") as saved:
        np.savez(tmp_path / "checkpoint.npz", **{**saved, "format": np.array(3)})
    with pytest.raises(UsageError, match="expected a checkpoint of format 4, got format 3") as no:
        train.resume(tmp_path)
    assert "\n" not in str(no.value)


def test_missing_checkpoint_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no checkpoint here"):
        train.resume(tmp_path)


def test_checkpoint_of_another_network_is_refused(config: TrainConfig, tmp_path: Path) -> None:
    learner = new_learner(config)
    other = dataclasses.replace(config, network=NetworkConfig(hidden=(4,)))
    with pytest.raises(UsageError, match="weights: expected shape"):
        new_learner(other).restore(learner.arrays())
