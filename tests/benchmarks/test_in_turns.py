"""What two checkouts are compared in, and what is refused before and after."""

import sys
from pathlib import Path

import in_turns
import pytest


def test_every_number_has_the_words_that_lead_to_it() -> None:
    document = [
        {"policy": "blind", "warm": True, "best": 2, "rates": [1.5, 2.5]},
        {"policy": "random", "best": 3.0, "none": None},
    ]
    assert dict(in_turns.figures(document)) == {
        "0 blind True best": 2.0,
        "0 blind True rates 0": 1.5,
        "0 blind True rates 1": 2.5,
        "1 random best": 3.0,
    }


def test_what_never_differs_and_what_one_side_lacks_is_not_compared() -> None:
    rounds: list[in_turns.Round] = [
        ({"agents": 4096.0, "best": 2.0, "old": 1.0}, {"agents": 4096.0, "best": 3.0, "new": 1.0}),
        ({"agents": 4096.0, "best": 4.0, "old": 1.0}, {"agents": 4096.0, "best": 4.0, "new": 1.0}),
    ]
    (line,) = in_turns.compared(rounds)
    assert line.split() == ["best", "3", "3.5", "ratio", "1.250"]
    assert list(in_turns.one_sided(rounds)) == ["only in the other: old", "only in this one: new"]


def checkout(folder: Path, said: str = "{}", status: int = 0) -> Path:
    """A checkout whose Python says the same whatever it is given."""
    python = folder / ".venv" / "bin" / "python"
    python.parent.mkdir(parents=True)
    python.write_text(f"#!/bin/sh\necho '{said}'\nexit {status}\n")
    python.chmod(0o755)
    return folder


def compare(monkeypatch: pytest.MonkeyPatch, here: Path, *words: object) -> None:
    monkeypatch.setattr(in_turns, "HERE", here)
    monkeypatch.setattr(sys, "argv", ["in_turns.py", *map(str, words), "--", "world.py"])
    in_turns.main()


def test_both_run_in_turns(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    before = checkout(tmp_path / "before", '{"best": 2, "old": 1}')
    compare(monkeypatch, checkout(tmp_path / "now", '{"best": 3}'), before)
    said = capsys.readouterr()
    assert said.out.split() == ["best", "2", "3", "ratio", "1.500"]
    assert "only in the other: old" in said.err


@pytest.mark.parametrize(
    ("before", "words", "reason"),
    [
        (("{}", 0), ["--rounds", "0"], "--rounds: expected 1 or more, got 0"),
        (("{}", 3), [], "ended with 3"),
        (("nothing", 0), [], "expected JSON, got 'nothing"),
        (('{"other": 1}', 0), [], "expected figures that both checkouts have"),
        (('{"best": 3}', 0), [], "expected figures that both checkouts have"),
        (None, [], "expected a checkout with .venv"),
    ],
)
def test_what_cannot_be_compared_is_refused_in_one_line(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    before: tuple[str, int] | None,
    words: list[str],
    reason: str,
) -> None:
    other = checkout(tmp_path / "before", *before) if before else tmp_path / "nowhere"
    with pytest.raises(SystemExit) as end:
        compare(monkeypatch, checkout(tmp_path / "now", '{"best": 3}'), other, *words)
    assert end.value.code == 2
    (line,) = [line for line in capsys.readouterr().err.splitlines() if "in_turns" in line]
    assert reason in line
