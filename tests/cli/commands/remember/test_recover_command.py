import json
from pathlib import Path

from reflexarc.main import main

GOLDEN = Path(__file__).parents[3] / "golden" / "nominal.mcap"


def test_the_status_says_whether_something_was_lost(tmp_path: Path, capsys):
    broken = tmp_path / "a b.mcap"
    broken.write_bytes(GOLDEN.read_bytes()[:30_000])
    assert main(["recover", str(GOLDEN), "-o", str(tmp_path / "whole.mcap")]) == 0
    assert "lost      nothing" in capsys.readouterr().out
    assert main(["recover", str(broken), "-o", str(tmp_path / "saved it.mcap")]) == 1
    said = capsys.readouterr()
    assert "lost, end" in said.out
    assert f"reflexarc replay '{tmp_path}/saved it.mcap'" in said.err
    assert main(["recover", str(broken), "-o", str(tmp_path / "other.mcap"), "--json"]) == 1
    told = json.loads(capsys.readouterr().out)
    assert told["losses"][-1]["place"] == "end"
    broken.write_bytes(b"no log")
    assert main(["recover", str(broken), "-o", str(tmp_path / "none.mcap")]) == 2
