"""The ten lines that read a log with the plain MCAP library do so, on a golden log."""

import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from reflexarc_logs.reading.reader import Record, read_log
from reflexarc_runtime.messages_pb2 import Decision, Tick

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "viewers.md").read_text()
NOMINAL = ROOT / "tests" / "golden" / "nominal.mcap"
MOST_LINES = 10


def code() -> str:
    found = re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert found is not None
    return found[1]


def test_the_lines_print_every_decision_of_a_golden_log(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "runs").mkdir()
    shutil.copy(NOMINAL, tmp_path / "runs" / "drive.mcap")
    monkeypatch.chdir(tmp_path)
    exec(code(), {})
    said = capsys.readouterr().out.splitlines()
    expected = [
        f"{record.log_ns} {decision.index} {decision.action} {list(decision.q_values)}"
        for record, decision in _decisions()
        if decision.q_values
    ]
    assert said == expected
    assert len(said) == 298


def _decisions() -> Iterator[tuple[Record, Decision]]:
    log = read_log(NOMINAL)
    for record, tick in log.messages(log.topic("tick"), Tick):
        yield record, tick.decision


def test_they_are_ten_and_need_nothing_of_ours() -> None:
    assert len([line for line in code().splitlines() if line.strip()]) <= MOST_LINES
    assert "reflexarc" not in code()


def test_the_log_names_the_clocks_that_the_page_does() -> None:
    said = read_log(NOMINAL).metadata["reflexarc.run"]
    assert said["publish_clock"] == "wall"
    assert int(said["wall_offset_ns"]) > 0
