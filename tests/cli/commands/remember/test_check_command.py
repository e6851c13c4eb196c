import json
import shutil
from pathlib import Path

import pytest

from reflexarc.main import main

GOLDEN = Path(__file__).parents[3] / "golden"


def test_one_line_a_log_the_worst_first_then_the_findings(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("nominal", "faults"):
        shutil.copy(GOLDEN / f"{name}.mcap", tmp_path)
    assert main(["check", str(tmp_path), "--jobs", "1"]) == 1
    head, worst, best, *findings = capsys.readouterr().out.splitlines()
    assert head.split()[0] == "verdict"
    assert worst.startswith("4 warnings")
    assert worst.endswith("faults.mcap")
    assert best.startswith("sound")
    assert findings[0] == f"{tmp_path}/faults.mcap: 4 warnings"
    assert any("silent for 260.0 ms (13 periods of 20.0 ms)" in line for line in findings)


def test_the_status_is_that_of_the_worst(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    nominal, missing = str(GOLDEN / "nominal.mcap"), str(tmp_path / "none.mcap")
    assert main(["check", nominal, "--json"]) == 0
    [log] = json.loads(capsys.readouterr().out)["logs"]
    assert (log["verdict"], log["replay"], log["findings"]) == ("sound", "identical", [])
    assert main(["check", nominal, missing, "--json", "--jobs", "1"]) == 2
    assert main(["check", nominal, "--jobs", "1000"]) == 2
    assert main(["check", str(tmp_path)]) == 2
