"""`reflexarc study`: what its flags say and show; what it does is in `end_to_end/test_study.py`."""

import json
from pathlib import Path

import pytest

from reflexarc.main import main
from reflexarc_trainer.study.shipped import study_named, study_names


def test_shipped_studies_are_listed_with_their_questions(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["study", "--list", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["studies"]
    assert [row["name"] for row in rows] == list(study_names())
    assert main(["study", "--list"]) == 0
    assert "How many hidden units" in " ".join(capsys.readouterr().out.split())


def test_what_is_shown_is_the_file(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["study", "edge", "--show"]) == 0
    assert capsys.readouterr().out == study_named("edge").text


def test_dry_run_tells_cells_runs_and_a_time(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["study", "held", "--dry-run", "--jobs", "2"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "14 cells × 5 seeds = 70 runs" in said
    assert "minutes with --jobs 2" in said


def test_dry_run_does_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["study", "edge", "--dry-run", "-o", str(tmp_path / "dry"), "--json"]
    assert main(words) == 0
    plan = json.loads(capsys.readouterr().out)
    assert (plan["units"], plan["pending"], len(plan["cells"])) == (48, 48, 6)
    assert not (tmp_path / "dry").exists()


def test_file_that_is_no_study_leaves_nothing_behind(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "bad.toml").write_text(study_named("gamma").text.replace("0.98]", "1.5]"))
    assert main(["study", str(tmp_path / "bad.toml"), "-o", str(tmp_path / "bad")]) == 2
    complaint = capsys.readouterr().err
    assert complaint.count("\n") == 1
    assert "1.5: learner.gamma: expected in [0, 1)" in complaint
    assert "bad.toml:24: axis[1].values[6]" in complaint
    assert not (tmp_path / "bad").exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ([], "the name or the file of a study"),
        (["--list", "held"], "no study with --list"),
        (["zebra"], "none is named 'zebra'"),
        (["none.toml"], "none.toml: cannot be read"),
        (["held", "--jobs", "-1"], "--jobs"),
    ],
)
def test_wrong_use_is_told_in_one_line(
    words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["study", *words]) == 2
    complaint = capsys.readouterr().err
    assert said in complaint
    assert complaint.count("\n") == 1
