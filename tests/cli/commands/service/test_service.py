import hashlib
import json
import os
import pwd
import shlex
from pathlib import Path
from tempfile import TemporaryDirectory
from types import SimpleNamespace

import pytest

import reflexarc
from reflexarc.commands.service import service
from reflexarc.main import main
from reflexarc.wiring.installing import service_access
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.service.service_user import READ, ServiceUser
from support.policies import exported

ME = pwd.getpwuid(os.getuid()).pw_name


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


def installed(config: Path, units: Path, *words: str) -> int:
    """As this user, who may read the folders of tests."""
    return main(["service", "install", str(config), "--units", str(units), "--user", ME, *words])


def test_the_unit_is_shown_installed_and_removed(config, units, capsys):
    words = [str(config), "--units", str(units), "--user", ME]
    assert main(["service", "show", *words]) == 0
    shown = capsys.readouterr().out
    assert main(["service", "install", *words]) == 0
    path = units / "reflexarc-rover1.service"
    assert path.read_text() == shown
    assert f"run --config {config}" in shown
    assert "systemctl daemon-reload" in capsys.readouterr().out
    assert main(["service", "remove", *words]) == 0
    assert list(units.iterdir()) == []
    assert main(["service", "install", *words]) == 0
    capsys.readouterr()
    assert main(["service", "remove", *words, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["text"] == shown


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
        ('policy = "policy.onnx"\nticks = 100', "ticks: expected"),
        ('policy = "policy.onnx"\nport = 0', "--port: expected 1 to 65535"),
        ('policy = "policy.onnx"\nrobot = "a b"', "--robot: expected letters"),
        ('policy = "policy.onnx"\nrobot = "a/../../b"', "--robot: expected letters"),
        ('policy = "policy.onnx"\nrobot = "x\\nExecStartPre=+/bin/sh"', "--robot: expected"),
        ('policy = "policy.onnx"\nspin-us = -1', "--spin-us"),
        ('policy = "policy.onnx"\nwatchdog-ms = 0', "--watchdog-ms"),
        ('policy = "policy.onnx"\nmetrics = 70000', "--metrics"),
        ('policy = "policy.onnx"\nzenoh = "missing.json5"', "missing.json5: no such file"),
        ('policy = "policy.onnx"\nzenoh = "policy.onnx"', "policy.onnx"),
        ('policy = "policy.onnx"\nzenoh = "open.json5"', "strangers cannot join"),
        (f'policy = "policy.onnx"\nexpect-hash = "{"0" * 64}"', "--expect-hash"),
        ('policy = "policy.onnx"\nrequire-signature = "none.pub"', "none.pub"),
        ('policy = "policy.onnx"\nshadow = "missing.onnx"', "missing.onnx"),
        ('policy = "policy.onnx"\nshadow = "other.onnx"', "other.onnx"),
        ('policy = "policy.onnx"\ncpu = [5000]', "--cpu"),
    ],
)
def test_what_cannot_run_is_not_installed(text, said, config, units, capsys):
    (config.parent / "open.json5").write_text("{}")
    (config.parent / "other.onnx").write_bytes(b"none")
    config.write_text(text)
    assert installed(config, units) == 2
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
def test_a_service_records_into_folders_that_it_may_write_to(text, said, config, units, capsys):
    config.write_text(f"{config.read_text()}{text}\n")
    assert installed(config, units) == 2
    assert said in capsys.readouterr().err
    assert list(units.iterdir()) == []


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


def test_metrics_that_others_scrape_open_the_network(config, capsys):
    assert "IPAddressDeny=any" in shown(config, capsys)
    config.write_text(f"{config.read_text()}metrics = 9464\n")
    assert "IPAddressDeny=any" in shown(config, capsys)
    config.write_text(f'{config.read_text()}metrics-host = "0.0.0.0"\n')
    assert "IPAddress" not in shown(config, capsys)


def shown(config: Path, capsys: "pytest.CaptureFixture[str]") -> str:
    assert main(["service", "show", str(config)]) == 0
    return capsys.readouterr().out


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


def test_what_nobody_signed_is_not_parsed(config, units, capsys):
    """`install` is usually root's: a file that is no policy at all is not looked into."""
    pytest.importorskip("cryptography")
    assert main(["secure", "key", str(config.parent / "k.key")]) == 0
    config.write_text(f'{config.read_text()}require-signature = "k.pub"\n')
    (config.parent / "policy.onnx").write_bytes(b"no ONNX at all")
    for action in ("install", "show"):
        assert main(["service", action, str(config), "--units", str(units), "--user", ME]) == 2
        assert "signature" in capsys.readouterr().err


def test_a_hash_that_is_right_is_installed(config, units):
    found = hashlib.sha256((config.parent / "policy.onnx").read_bytes()).hexdigest()
    config.write_text(f'{config.read_text()}expect-hash = "{found}"\n')
    assert installed(config, units) == 0


@pytest.mark.parametrize(
    ("rate_hz", "text", "longest_s"),
    [
        (50.0, "", 0.52),  # half a second, and a period
        (0.1, "", 10.5),
        (2.0, 'pace = "input"', 1.5),  # two periods
        (50.0, "watchdog-ms = 2000", 8.02),  # four times that, and a period
    ],
)
def test_the_manager_waits_longer_than_the_loops_own_timer(
    rate_hz, text, longest_s, config, capsys
):
    """What the loop may take is worked out by hand, from docs/watchdog.md."""
    contract = PolicyContract(rate_hz=rate_hz)
    (config.parent / "policy.onnx").write_bytes(exported(contract))
    config.write_text(f"{config.read_text()}{text}\n")
    assert main(["service", "show", str(config)]) == 0
    found = float(capsys.readouterr().out.partition("WatchdogSec=")[2].partition("\n")[0])
    assert found >= max(1.0, 1.4 * longest_s)
    assert main(["service", "show", str(config), "--watchdog-s", f"{longest_s - 0.01}"]) == 2
    assert f"--watchdog-s: expected more than {longest_s:g}" in capsys.readouterr().err


def test_what_is_not_there_is_not_removed(config, tmp_path, capsys):
    assert main(["service", "remove", str(config), "--units", str(tmp_path)]) == 2
    assert "no such unit" in capsys.readouterr().err


def test_a_robot_is_removed_by_its_name_when_its_settings_are_gone(config, units, capsys):
    assert installed(config, units) == 0
    config.write_text("none of these = any more")
    assert main(["service", "remove", str(config), "--units", str(units)]) == 2
    assert "`reflexarc service remove ROBOT` needs no file" in capsys.readouterr().err
    assert main(["service", "remove", "rover1", "--units", str(units)]) == 0
    assert list(units.iterdir()) == []
