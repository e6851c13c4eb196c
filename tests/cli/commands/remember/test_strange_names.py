"""Logs whose names look like markup, formulas, or orders to a terminal."""

import os
import shutil
from pathlib import Path

import pytest

from reflexarc.main import main

GOLDEN = Path(__file__).parents[3] / "golden" / "nominal.mcap"
NAMES = [
    "[red]d[-3]",
    r"a$\foo$",
    ":smile:",
    os.fsdecode(b"\x1b[31m\xff\n"),
    "-x",
]
COMMANDS = {
    "info": ("{log}",),
    "replay": ("{log}",),
    "check": ("{log}",),
    "recover": ("{log}", "-o", "{out}"),
    "cut": ("{log}", "--from", "1", "--to", "9", "-o", "{out}"),
    "render": ("{log}", "-o", "x.png"),
}


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("command", COMMANDS)
def test_a_name_is_a_name(
    command: str,
    name: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
):
    monkeypatch.chdir(tmp_path)
    places = {"log": f"./{name}.mcap", "out": f"./{name}-2.mcap"}
    shutil.copy(GOLDEN, places["log"])
    assert main([command, *(word.format(**places) for word in COMMANDS[command])]) == 0
    said = capsys.readouterr()
    assert "\x1b" not in said.out + said.err
    if command in ("info", "replay", "check") and name.isprintable():
        assert f"{name}.mcap" in said.out
