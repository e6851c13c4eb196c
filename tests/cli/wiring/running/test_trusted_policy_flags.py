"""A policy that was accepted is the one that is loaded."""

import hashlib
from pathlib import Path

import pytest

from reflexarc.wiring.running.trusted_policy_flags import TrustedPolicyFlags
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import PolicyError
from reflexarc_runtime.policy.policy import load_policy
from support.policies import exported


def test_a_file_that_is_changed_between_the_look_and_the_load_is_refused(tmp_path: Path):
    path, mine = tmp_path / "policy.onnx", exported(PolicyContract(), seed=5)
    path.write_bytes(mine)
    flags = TrustedPolicyFlags(expect_hash=hashlib.sha256(mine).hexdigest().upper())
    accepted = flags.check_file(path)
    flags.check_loaded(accepted, load_policy(path))
    path.write_bytes(exported(PolicyContract(), seed=6))
    with pytest.raises(PolicyError, match="changed while it was read"):
        flags.check_loaded(accepted, load_policy(path))
    with pytest.raises(PolicyError, match="--expect-hash"):
        flags.check_file(path)


def test_without_the_flags_any_file_is_taken(tmp_path: Path):
    assert TrustedPolicyFlags().check_file(tmp_path / "none.onnx") is None
