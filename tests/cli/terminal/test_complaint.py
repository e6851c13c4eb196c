"""What tyro itself says of wrong flags, in one line without repetition."""

import io
import sys

import pytest

from reflexarc.main import main


def complaint(words: str, capsys: pytest.CaptureFixture[str]) -> str:
    with pytest.raises(SystemExit) as end:
        main(words.split())
    assert end.value.code == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    return line.removeprefix("reflexarc: ")


COMPLAINTS = {
    "sim --steps x": "--steps: expected INT, got 'x'; see `reflexarc sim --help`",
    "sim --wrld open": (
        "unrecognized options: --wrld, open; similar: --world; see `reflexarc sim --help`"
    ),
    "run p.onnx --backend foo": (
        "invalid choice 'foo' for argument '--backend'. Expected one of ('numpy', 'onnxruntime'); "
        "see `reflexarc run --help`"
    ),
    "run p.onnx --mount 1": (
        "--mount: expected FLOAT FLOAT FLOAT, got '1'; see `reflexarc run --help`"
    ),
    "sim --[red]x[/red]": ("unrecognized options: --[red]x[/red]; see `reflexarc sim --help`"),
}


@pytest.mark.parametrize("words", COMPLAINTS)
def test_a_complaint_says_a_thing_once(words: str, capsys: pytest.CaptureFixture[str]):
    assert complaint(words, capsys) == COMPLAINTS[words]


@pytest.mark.parametrize("words", ["fly", "ros2 --nosuch 1", "run", "import carmen x", "--steps 3"])
def test_no_three_words_stand_in_it_twice(words: str, capsys: pytest.CaptureFixture[str]):
    said = complaint(words, capsys).lower().split()
    threes = list(zip(said, said[1:], said[2:], strict=False))
    assert len(threes) == len(set(threes))
    assert sum(word.startswith("--help") for word in said) == 1


def test_a_stream_that_takes_ascii_only_gets_the_same_complaint(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(io.BytesIO(), encoding="ascii"))
    for words, said in COMPLAINTS.items():
        assert complaint(words, capsys) == said
