"""What was accepted is what is tried and loaded: the file is read once."""

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from reflexarc.wiring.running.driving_policy import tried_policy
from reflexarc.wiring.running.trusted_policy_flags import TrustedPolicyFlags
from reflexarc_runtime.contract.bounds import Bounds
from reflexarc_runtime.errors import ContractError, PolicyError
from reflexarc_runtime.policy.policy import policy_hash
from support.policies import SMALL, exported

MINE, OTHER = exported(SMALL, seed=5), exported(SMALL, seed=6)


@contextmanager
def read_once(path: Path, data: bytes) -> Iterator[None]:
    """A pipe with a name: whoever reads it a second time gets nothing."""
    os.mkfifo(path)
    writer = threading.Thread(target=lambda: path.write_bytes(data))
    writer.start()
    yield
    writer.join()


@pytest.mark.parametrize("backend", ["numpy", "onnxruntime"])
def test_a_file_is_read_once_for_all(backend: str, tmp_path: Path):
    path = tmp_path / "policy.onnx"
    with read_once(path, MINE):
        accepted = TrustedPolicyFlags(expect_hash=policy_hash(MINE)).check_file(path)
    path.unlink()
    path.write_bytes(OTHER)  # what somebody puts there meanwhile
    finding, policy = tried_policy(path, accepted, backend, Bounds())
    assert policy.data == MINE
    assert finding.policy_hash == policy.policy_hash == policy_hash(MINE)


def test_errors_name_the_file(tmp_path: Path):
    path = tmp_path / "policy.onnx"
    with pytest.raises(PolicyError, match=rf"^{path}: expected an ONNX model"):
        tried_policy(path, b"none", "numpy", Bounds())
    with pytest.raises(ContractError, match=rf"^{path}: "):
        tried_policy(path, MINE, "numpy", Bounds(max_speed_mps=1e-3))
