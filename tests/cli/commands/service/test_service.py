import hashlib
import json
from pathlib import Path

import pytest

from reflexarc.commands.service import service
from reflexarc.main import main
from reflexarc_runtime.contract.contract import PolicyContract
from support.installing import ME, installed
from support.policies import exported


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
        ('policy = "other.onnx"', "other.onnx: expected an ONNX model"),
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


def test_metrics_that_others_scrape_open_the_network(config, capsys):
    assert "IPAddressDeny=any" in shown(config, capsys)
    config.write_text(f"{config.read_text()}metrics = 9464\n")
    assert "IPAddressDeny=any" in shown(config, capsys)
    config.write_text(f'{config.read_text()}metrics-host = "0.0.0.0"\n')
    assert "IPAddress" not in shown(config, capsys)


def shown(config: Path, capsys: "pytest.CaptureFixture[str]") -> str:
    assert main(["service", "show", str(config)]) == 0
    return capsys.readouterr().out


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
