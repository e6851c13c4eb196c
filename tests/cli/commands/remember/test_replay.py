import json
from pathlib import Path

from reflexarc_runtime.contract.contract import PolicyContract
from support.policies import exported
from support.processes import reflexarc as call

GOLDEN = Path(__file__).parents[3] / "golden" / "nominal.mcap"


def test_replay_answers_with_its_exit_status(tmp_path: Path):
    other = tmp_path / "other.onnx"
    other.write_bytes(exported(PolicyContract(), seed=99))
    same = call("replay", GOLDEN, "--json")
    assert (same.returncode, json.loads(same.stdout)["verdict"]) == (0, "identical")
    changed = call("replay", GOLDEN, "--policy", other)
    assert changed.returncode == 1
    assert "tick" in changed.stdout
