from pathlib import Path

import pytest

from reflexarc.commands.drive.run import RunCommand
from reflexarc.config_file.printing import as_toml
from reflexarc.config_file.reading import config_in, settings_of
from reflexarc.main import main
from reflexarc_runtime.errors import UsageError

FULL = """
policy = "policy.onnx"
robot = "rover1"
input = "scan"
mount = [0.1, 0, 180]
no-return = ["zero", "nan"]
rotate_s = 600
record = "/var/log/robot"
no-watchdog = true
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "robot.toml"
    path.write_text(text)
    return path


def test_keys_are_flags_and_the_rest_has_its_defaults(tmp_path):
    command = settings_of(RunCommand, written(tmp_path, FULL))
    assert command.policy == tmp_path / "policy.onnx"
    assert command.record == Path("/var/log/robot")
    assert command.joining.robot == "rover1"
    assert command.sensing.scanner.mount == (0.1, 0.0, 180.0)
    assert command.recording.rotate_s == 600.0
    assert command.watching.no_watchdog
    assert command.joining.port == RunCommand(Path()).joining.port


def test_what_is_printed_reads_the_same(tmp_path):
    command = settings_of(RunCommand, written(tmp_path, FULL))
    assert settings_of(RunCommand, written(tmp_path, as_toml(command))) == command


def test_the_command_line_counts_more(tmp_path, capsys):
    path = written(tmp_path, FULL)
    assert main(["run", "other.onnx", "--config", str(path), "--robot", "r2", "--show-config"]) == 0
    said = capsys.readouterr().out
    assert 'robot = "r2"' in said
    assert "other.onnx" in said
    assert 'input = "scan"' in said


@pytest.mark.parametrize("flag", ["no-watchdog", "no-guard", "allow-swap", "json"])
@pytest.mark.parametrize("in_file", ["true", "false"])
@pytest.mark.parametrize(("form", "said"), [("--", "true"), ("--no-", "false")])
def test_a_switch_on_the_command_line_counts_more_whatever_the_file_says(
    flag, in_file, form, said, tmp_path, capsys
):
    path = written(tmp_path, f"policy = 'p.onnx'\n{flag} = {in_file}")
    assert main(["run", "--config", str(path), f"{form}{flag}", "--show-config"]) == 0
    assert f"\n{flag} = {said}\n" in capsys.readouterr().out


def test_two_files_are_refused(tmp_path, capsys):
    one, other = written(tmp_path, "robot = 'x'"), tmp_path / "other.toml"
    other.write_text("robot = 'y'")
    words = ["run", "p.onnx", "--config", str(one), f"--config={other}", "--show-config"]
    assert main(words) == 2
    assert f"--config: expected one file, got {one} and {other}" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("policy = 3", "1: policy: expected a path, got 3"),
        ("\nrobott = 'x'", "2: robott: unknown; known: policy, "),
        ("port = 'x'", "1: port: expected a whole number, got 'x'"),
        ("input = 'sonar'", "1: input: expected retina or scan"),
        ("rotate-s = 1\nrotate_s = 2", "2: rotate_s: expected once, got twice"),
        ("no-watchdog = 1", "1: no-watchdog: expected"),
        ("[joining]\nrobot = 'x'", "1: joining: unknown"),
        ("config = 'x'", "1: config: unknown"),
        ('policy = "a\\u0000b"', "1: policy: expected a path, got 'a\\x00b'"),
        ('port = 1\nzenoh = "k\\u0000"', "2: zenoh: expected a path"),
        ('record = ""', "1: record: expected a path, got ''"),
        ("robot = ", "1: expected TOML"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(text, said, tmp_path):
    path = written(tmp_path, text)
    with pytest.raises(UsageError) as refused:
        settings_of(RunCommand, path)
    assert str(refused.value).startswith(f"{path}:{said}")


def test_a_policy_may_be_left_to_the_command_line(tmp_path, capsys):
    path = written(tmp_path, "robot = 'x'")
    with pytest.raises(SystemExit) as end:
        main(["run", "--config", str(path)])
    assert end.value.code == 2
    assert "policy" in capsys.readouterr().err
    assert main(["run", "p.onnx", "--config", str(path), "--show-config"]) == 0


@pytest.mark.parametrize(
    ("words", "path"),
    [
        (["run", "--config", "a.toml"], Path("a.toml")),
        (["run", "--config=a.toml"], Path("a.toml")),
        (["run", "p.onnx"], None),
        (["run", "--config"], None),
        (["run", "--", "--config", "a.toml"], None),
    ],
)
def test_the_file_is_found_before_the_flags_are_parsed(words, path):
    assert config_in(words) == path
