import json
from pathlib import Path

import pytest

from reflexarc.commands.service import service
from reflexarc.main import main
from reflexarc_runtime.contract.contract import PolicyContract
from support.policies import exported


@pytest.fixture
def config(tmp_path: Path) -> Path:
    (tmp_path / "policy.onnx").write_bytes(exported(PolicyContract()))
    path = tmp_path / "robot.toml"
    path.write_text('policy = "policy.onnx"\nrobot = "rover1"\n')
    return path


def test_the_unit_is_shown_installed_and_removed(config, tmp_path, capsys):
    units = tmp_path / "units"
    units.mkdir()
    words = [str(config), "--units", str(units)]
    assert main(["service", "show", *words]) == 0
    shown = capsys.readouterr().out
    assert main(["service", "install", *words]) == 0
    path = units / "reflexarc-rover1.service"
    assert path.read_text() == shown
    assert f"run --config {config}" in shown
    assert "systemctl daemon-reload" in capsys.readouterr().out
    assert main(["service", "remove", *words]) == 0
    assert list(units.iterdir()) == []


def test_a_program_reads_it_as_json(config, capsys):
    assert main(["service", "show", str(config), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["unit"] == "reflexarc-rover1.service"
    assert said["path"] == str(service.SYSTEM_UNITS / said["unit"])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('robot = "x"', "policy: missing"),
        ('policy = "none.onnx"', "none.onnx"),
        ('policy = "policy.onnx"\nlockstep = true', "real time"),
        ('policy = "policy.onnx"\nwatchdogs = 1', "watchdogs: unknown"),
    ],
)
def test_what_cannot_run_is_not_installed(text, said, config, tmp_path, capsys):
    config.write_text(text)
    units = tmp_path / "units"
    units.mkdir()
    assert main(["service", "install", str(config), "--units", str(units)]) == 2
    assert said in capsys.readouterr().err
    assert list(units.iterdir()) == []


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('record = "drive.mcap"', "record: expected a folder"),
        ('record = "drive"', "record: expected a folder"),
        ('record = "logs"\nrotate-s = 60', "may write below /var/lib/reflexarc-rover1 only"),
        ('record = "/var/lib/reflexarc-rover1/../x"\nrotate-s = 60', "may write below"),
        ("black-box = 30", "expected black-box-out beside it"),
        ('black-box = 30\nblack-box-out = "boxes"', "black-box-out: "),
    ],
)
def test_a_service_records_into_folders_that_it_may_write_to(text, said, config, tmp_path, capsys):
    config.write_text(f"{config.read_text()}{text}\n")
    units = tmp_path / "units"
    units.mkdir()
    assert main(["service", "install", str(config), "--units", str(units)]) == 2
    assert said in capsys.readouterr().err
    assert list(units.iterdir()) == []


def test_another_folder_is_allowed_by_name(config, tmp_path):
    config.write_text(f'{config.read_text()}record = "logs"\nkeep-mb = 100\n')
    units = tmp_path / "units"
    units.mkdir()
    words = ["service", "install", str(config), "--units", str(units)]
    assert main([*words, "--writes", str(tmp_path)]) == 0
    assert f"ReadWritePaths={tmp_path}" in next(units.iterdir()).read_text()


def test_what_is_not_there_is_not_removed(config, tmp_path, capsys):
    assert main(["service", "remove", str(config), "--units", str(tmp_path)]) == 2
    assert "no such unit" in capsys.readouterr().err
