from pathlib import Path

import pytest

from reflexarc_runtime.policy.policy import LoadedPolicy, load_policy
from support.policies import exported
from support.recordings import CONTRACT, drive, nominal
from support.staged_incidents import contact, mark, staged, stopped_between

TICKS = 400


@pytest.fixture(scope="session")
def candidate_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("candidate") / "candidate.onnx"
    path.write_bytes(exported(CONTRACT, seed=4, activation="Relu"))
    return path


@pytest.fixture(scope="session")
def candidate(candidate_file: Path) -> LoadedPolicy:
    return load_policy(candidate_file)


@pytest.fixture(scope="session")
def driven(policy: bytes, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A drive of 8 s that touches something, is marked, and is stopped by a hand for a second."""
    folder = tmp_path_factory.mktemp("driven")
    schedule = nominal(TICKS)
    stopped_between(schedule, 250, 300)
    drive(folder / "plain.mcap", policy, schedule, TICKS)
    heard = {120: contact(1), 200: mark("here it was odd")}
    return staged(folder / "plain.mcap", folder / "drive.mcap", heard)
