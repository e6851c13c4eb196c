import socket
from pathlib import Path

import pytest

from reflexarc_runtime.contract.contract import PolicyContract
from support.policies import exported


@pytest.fixture(scope="session")
def policy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An exported policy of random weights with the eye of the reference field."""
    path = tmp_path_factory.mktemp("policy") / "policy.onnx"
    path.write_bytes(exported(PolicyContract(), seed=5))
    return path


@pytest.fixture
def port() -> int:
    """A port that nobody listens on."""
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return int(listener.getsockname()[1])
