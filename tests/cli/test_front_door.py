import ast
import json
import subprocess
import sys
from pathlib import Path

import pytest

import reflexarc
from reflexarc.main import COMMANDS, main
from support.processes import reflexarc as call

PUBLIC = [
    "Policy",
    "PolicyContract",
    "ReferenceEnv",
    "ReferenceVectorEnv",
    "ReflexarcError",
    "RetinaSpec",
    "export",
    "load_policy",
    "measure",
    "preset_named",
    "read_log",
    "replay",
    "train",
    "world_named",
]


def test_the_public_names_are_these_and_each_can_be_loaded():
    assert reflexarc.__all__ == PUBLIC
    assert dir(reflexarc) == sorted(PUBLIC)
    assert all(getattr(reflexarc, name).__name__ == name for name in PUBLIC)
    assert reflexarc.__version__ == "0.1.0"
    with pytest.raises(AttributeError, match="no attribute 'fly'"):
        reflexarc.fly  # noqa: B018


def test_importing_the_facade_loads_no_room():
    code = "import reflexarc, sys; print([m for m in sys.modules if m.startswith('reflexarc_')])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ast.literal_eval(done.stdout) == []


@pytest.mark.parametrize("command", [kind.__name__.lower() for kind in COMMANDS])
def test_every_command_says_what_it_is_with_examples(
    command: str, capsys: pytest.CaptureFixture[str]
):
    with pytest.raises(SystemExit) as end:
        main([command, "--help"])
    said = capsys.readouterr().out
    assert end.value.code == 0
    assert "Examples:" in said
    assert f"reflexarc {command}" in said.partition("Examples:")[2]


def test_a_policy_and_a_log_say_what_they_are(golden: Path, tmp_path: Path):
    from reflexarc_logs.reading.reader import read_log

    policy = tmp_path / "policy.onnx"
    policy.write_bytes(read_log(golden).policy or b"")
    assert json.loads(call("info", policy, "--json").stdout)["contract"]["rate_hz"] == 50.0
    assert json.loads(call("info", golden, "--json").stdout)["complete"] is True
    assert "16 rays" in call("info", policy).stdout
    assert "/robot0/tick" in call("info", golden).stdout


def test_replay_answers_with_its_exit_status(golden: Path, tmp_path: Path):
    from reflexarc_runtime.contract import PolicyContract
    from support.policies import exported

    other = tmp_path / "other.onnx"
    other.write_bytes(exported(PolicyContract(), seed=99))
    same = call("replay", golden, "--json")
    assert (same.returncode, json.loads(same.stdout)["verdict"]) == (0, "identical")
    changed = call("replay", golden, "--policy", other)
    assert changed.returncode == 1
    assert "tick" in changed.stdout


@pytest.fixture
def golden() -> Path:
    return Path(__file__).parents[1] / "golden" / "nominal.mcap"
