"""What the user of a service may reach, looked at before its unit is written."""

import json
import os
import shlex
from pathlib import Path
from tempfile import TemporaryDirectory
from types import SimpleNamespace

import pytest

import reflexarc
from reflexarc.commands.service import service
from reflexarc.main import main
from reflexarc.wiring.installing import service_access
from reflexarc_runtime.service.service_user import READ, ServiceUser
from support.installing import installed


def test_another_folder_is_allowed_by_name(config, units, tmp_path):
    config.write_text(f'{config.read_text()}record = "logs"\nkeep-mb = 100\n')
    assert installed(config, units, "--writes", str(tmp_path)) == 0
    assert f"ReadWritePaths={tmp_path}" in next(units.iterdir()).read_text()


def test_a_folder_that_is_not_there_is_not_allowed(config, units, tmp_path, capsys):
    """systemd cannot mount it: 226/NAMESPACE at each start."""
    assert installed(config, units, "--writes", str(tmp_path / "none")) == 2
    assert "no such file" in capsys.readouterr().err


def test_what_the_user_of_the_service_cannot_read_is_said_before(config, units, tmp_path, capsys):
    tmp_path.chmod(0o700)
    words = ["service", "install", str(config), "--units", str(units)]
    assert main(words) == 2
    said = capsys.readouterr().err
    assert "the user that systemd makes for the service cannot" in said
    assert "--user NAME" in said
    assert list(units.iterdir()) == []


def test_what_lies_in_the_temporary_folder_is_not_there_for_a_service(
    config, units, tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr(service_access, "PRIVATE", (tmp_path,))
    assert installed(config, units) == 2
    assert f"the service has a {tmp_path} of its own" in capsys.readouterr().err


@pytest.mark.skipif(os.getuid() != 0, reason="makes a folder below /var/lib")
def test_a_user_that_systemd_makes_may_do_with_what_everybody_may_read(
    config, units, monkeypatch, capsys
):
    """What only its owner may read is the Zenoh configuration, which is handed over."""
    if ServiceUser().obstacle(Path(str(reflexarc.__file__)), READ):
        pytest.skip("this package lies where only its owner can read it")
    pytest.importorskip("cryptography")
    monkeypatch.setattr(service, "sys", SimpleNamespace(executable="/usr/bin/env"))
    with TemporaryDirectory(dir="/var/lib", prefix="reflexarc-test-") as made:
        folder = Path(made)
        folder.chmod(0o755)
        policy, settings = folder / "policy.onnx", folder / "robot.toml"
        policy.write_bytes((config.parent / "policy.onnx").read_bytes())
        settings.write_text(f'{config.read_text()}zenoh = "keys/runtime.json5"\n')
        assert main(["secure", "init", str(folder / "keys"), "--robot", "rover1"]) == 0
        words = ["service", "install", str(settings), "--units", str(units)]
        assert main(words) == 0
        assert "DynamicUser=yes" in next(units.iterdir()).read_text()
        monkeypatch.setattr(service, "systemd_version", lambda: 246)
        assert main(words) == 2
        assert f"zenoh: {folder}/keys/runtime.json5: " in capsys.readouterr().err
        policy.chmod(0o600)
        assert main(words) == 2
        assert f"{policy} is closed to it (mode 0600)" in capsys.readouterr().err


def test_an_unknown_user_is_refused(config, units, capsys):
    words = ["service", "install", str(config), "--units", str(units), "--user", "no-such-user"]
    assert main(words) == 2
    assert "expected a user of this machine" in capsys.readouterr().err


@pytest.fixture
def keys(config: Path) -> Path:
    """What `reflexarc secure init` makes, beside the settings, which name it."""
    pytest.importorskip("cryptography")
    assert main(["secure", "init", str(config.parent / "keys"), "--robot", "rover1"]) == 0
    config.write_text(f'{config.read_text()}zenoh = "keys/runtime.json5"\n')
    return config.parent / "keys"


def test_a_secured_robot_is_installed_and_its_key_handed_over(
    config, keys, units, monkeypatch, tmp_path
):
    """The file is 0600 below a folder 0700: no user that systemd makes could read it."""
    monkeypatch.setattr(service, "systemd_version", lambda: 252)
    assert installed(config, units) == 0
    text = next(units.iterdir()).read_text()
    assert f"LoadCredential=zenoh.json5:{keys}/runtime.json5\n" in text
    asked = shlex.split(text.partition("ExecStart=")[2].partition("\n")[0])
    assert asked[-2:] == ["--zenoh", "${CREDENTIALS_DIRECTORY}/zenoh.json5"]


def test_what_systemd_hands_over_is_what_the_loop_joins_by(config, keys, capsys):
    """As its command line says it: it counts more than the file of settings."""
    words = ["--zenoh", str(keys / "viewer.json5"), "--show-config"]
    assert main(["run", "--config", str(config), *words]) == 0
    assert f'zenoh = "{keys}/viewer.json5"' in capsys.readouterr().out


def test_keys_that_a_configuration_only_names_have_to_be_readable(config, units, tmp_path, capsys):
    named = {"connect_private_key": "own.key"}
    tls = {"protocols": ["tls"], "tls": named}
    settings = {
        "mode": "client",
        "connect": {"endpoints": ["tls/127.0.0.1:7447"]},
        "scouting": {"multicast": {"enabled": False}},
        "transport": {"link": tls},
    }
    (tmp_path / "own.json5").write_text(json.dumps(settings))
    config.write_text(f'{config.read_text()}zenoh = "own.json5"\n')
    assert installed(config, units) == 2
    assert "connect_private_key: expected an absolute path" in capsys.readouterr().err
    named["connect_private_key"] = str(tmp_path / "own.key")
    (tmp_path / "own.json5").write_text(json.dumps(settings))
    assert installed(config, units) == 2
    assert "own.key: no such file" in capsys.readouterr().err
