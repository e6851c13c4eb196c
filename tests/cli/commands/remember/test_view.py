from pathlib import Path

import pytest

from reflexarc.main import main

NOMINAL = str(Path(__file__).parents[3] / "golden" / "nominal.mcap")


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        ([], "expected a log, or --live"),
        ([NOMINAL, "--live"], "expected a log, or --live"),
        ([NOMINAL, "--web", "-o", "new.rrd"], "expected --web or -o"),
        ([NOMINAL, "-o", NOMINAL], "exists already"),
    ],
)
def test_what_cannot_be_meant_is_refused_before_anything_opens(
    words: list[str], complaint: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["view", *words]) == 2
    assert complaint in capsys.readouterr().err


def test_a_log_becomes_a_file_of_rerun(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("rerun")
    assert main(["view", NOMINAL, "-o", str(tmp_path / "out.rrd")]) == 0
    assert "601 messages" in capsys.readouterr().err
    assert (tmp_path / "out.rrd").stat().st_size > 10_000


def test_a_log_that_is_none_opens_no_viewer(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("rerun")
    assert main(["view", str(tmp_path / "missing.mcap")]) == 2
    assert "missing.mcap" in capsys.readouterr().err
