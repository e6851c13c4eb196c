import json
from pathlib import Path

from reflexarc_logs.reading.reader import read_log
from support.processes import reflexarc as call

GOLDEN = Path(__file__).parents[3] / "golden" / "nominal.mcap"


def test_a_policy_and_a_log_say_what_they_are(tmp_path: Path):
    policy = tmp_path / "policy.onnx"
    policy.write_bytes(read_log(GOLDEN).policy or b"")
    assert json.loads(call("info", policy, "--json").stdout)["contract"]["rate_hz"] == 50.0
    assert json.loads(call("info", GOLDEN, "--json").stdout)["complete"] is True
    assert "16 rays" in call("info", policy).stdout
    assert "/robot0/tick" in call("info", GOLDEN).stdout
