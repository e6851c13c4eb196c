from pathlib import Path

import pytest

from reflexarc_logs.container import writing as log_file
from support.policies import exported
from support.recordings import CONTRACT, drive, nominal

TICKS = 60


@pytest.fixture(scope="session")
def policy() -> bytes:
    return exported(CONTRACT, seed=3, activation="Relu")


@pytest.fixture(scope="session")
def log_path(policy: bytes, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recorded run of 60 ticks in many small chunks."""
    path = tmp_path_factory.mktemp("recorded") / "run.mcap"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(log_file, "CHUNK_BYTES", 2048)
        drive(path, policy, nominal(TICKS), TICKS)
    return path
