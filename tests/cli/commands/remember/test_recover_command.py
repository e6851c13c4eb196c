import json
import os
from pathlib import Path

from reflexarc.main import main
from reflexarc_logs.container.writing import LogWriter

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


def test_a_folder_is_recovered_at_once_but_for_what_is_being_written(tmp_path: Path, capsys):
    whole = GOLDEN.read_bytes()
    (tmp_path / "deep").mkdir()
    head = whole[:9_000]
    for name, data in (("a", whole[:30_000]), ("deep/b", whole[:90_000]), ("c", head)):
        (tmp_path / f"{name}.mcap.partial").write_bytes(data)
    living = LogWriter(tmp_path / "living.mcap")
    (tmp_path / "done.mcap").write_bytes(whole)
    (tmp_path / "done.mcap.partial").write_bytes(whole[:100])
    assert main(["check", str(tmp_path)]) == 0
    assert (
        f"3 unfinished logs are left out: `reflexarc recover {tmp_path}`" in capsys.readouterr().err
    )
    assert main(["recover", str(tmp_path), "--json"]) == 1
    told = json.loads(capsys.readouterr().out)
    saved = [os.path.relpath(one["path"], tmp_path) for one in told["saved"]]
    assert (saved, len(told["refused"])) == (["a.mcap", "deep/b.mcap"], 1)
    assert "c.mcap.partial" in told["refused"][0]
    living.discard()
    assert main(["recover", str(tmp_path)]) == 1
    assert "0 recovered, 1 with nothing to save" in capsys.readouterr().out
    (tmp_path / "c.mcap.partial").unlink()
    assert main(["recover", str(tmp_path)]) == 0


def test_one_log_wants_a_name_and_a_folder_wants_none(tmp_path: Path, capsys):
    assert main(["recover", str(GOLDEN)]) == 2
    assert "expected -o FILE.mcap" in capsys.readouterr().err
    assert main(["recover", str(tmp_path), "-o", str(tmp_path / "a.mcap")]) == 2
