"""For tests of services: settings of a robot, and a folder for its unit."""

from pathlib import Path

import pytest

from reflexarc.wiring.installing import service_access
from reflexarc_runtime.contract.contract import PolicyContract
from support.policies import exported


@pytest.fixture
def config(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(service_access, "PRIVATE", ())  # where the folders of tests are
    (tmp_path / "policy.onnx").write_bytes(exported(PolicyContract()))
    path = tmp_path / "robot.toml"
    path.write_text('policy = "policy.onnx"\nrobot = "rover1"\nno-guard = true\n')
    return path


@pytest.fixture
def units(tmp_path: Path) -> Path:
    folder = tmp_path / "units"
    folder.mkdir()
    return folder
