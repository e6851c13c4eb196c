"""A policy is tried in a process that can be ended."""

import time
from pathlib import Path

import pytest

from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.loop.trials.trial import Finding, Trial, check_fits
from reflexarc_runtime.policy.policy import load_policy
from support.looping_policies import FOR_EVER, looping
from support.policies import SMALL, exported


def found(path: Path, backend: str, loading_s: float = 60.0) -> Finding:
    with Trial(path, backend, loading_s) as trial:
        return trial.finding()


@pytest.mark.parametrize("backend", ["numpy", "onnxruntime"])
def test_a_good_policy_fits(tmp_path: Path, backend: str):
    path = tmp_path / "policy.onnx"
    path.write_bytes(exported(SMALL))
    finding = found(path, backend)
    assert 0 < finding.decision_ns < 1e9
    check_fits(Finding(finding.policy_hash, 1000), load_policy(path, backend))


def test_one_that_never_returns_is_ended(tmp_path: Path):
    path = tmp_path / "policy.onnx"
    path.write_bytes(looping(SMALL, FOR_EVER))
    began_s = time.monotonic()
    with pytest.raises(PolicyError, match=r"within 0\.5 s, got none: it hangs"):
        found(path, "onnxruntime", 0.5)
    assert time.monotonic() - began_s < 60.0


def test_what_the_process_refuses_is_refused_in_its_words(tmp_path: Path):
    path = tmp_path / "policy.onnx"
    with pytest.raises(PolicyError, match="cannot be read"):
        found(path, "numpy")
    path.write_bytes(b"no model")
    with pytest.raises(PolicyError, match="expected an ONNX model"):
        found(path, "numpy")


def test_a_decision_longer_than_the_period_is_refused_but_in_lockstep():
    policy = load_policy(exported(SMALL))
    slow = Finding(policy.policy_hash, 30_000_000)
    with pytest.raises(PolicyError, match=r"within 20 ms, the period at 50 Hz; got 30\.0 ms"):
        check_fits(slow, policy)
    check_fits(slow, policy, in_real_time=False)


def test_a_file_that_changed_after_its_trial_is_refused():
    with pytest.raises(PolicyError, match="changed"):
        check_fits(Finding("another", 1000), load_policy(exported(SMALL)))
