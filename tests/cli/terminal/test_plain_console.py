"""Words from outside on a terminal: neither markup nor orders."""

import io
import os
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.table import Table

from reflexarc.terminal.output import facts
from reflexarc.terminal.plain_console import PlainConsole, forget_unusable_size

GOLDEN = Path(__file__).parents[2] / "golden" / "nominal.mcap"
NAMES = ["a[/red]b", "[bold]x", ":smile:", "[link=http://x]y[/link]", "\\[x]", "[/]", "a[0]", "$x$"]


def printed(thing: object) -> str:
    file = io.StringIO()
    PlainConsole(file=file, width=200, color_system=None).print(thing)
    return file.getvalue()


@pytest.mark.parametrize("name", NAMES)
def test_a_name_is_shown_as_it_is(name: str):
    table = Table(name, title=name)
    table.add_row(name)
    assert printed(name).strip() == name
    assert printed(table).count(name) == 3
    assert name in printed(facts({"log": name}))


@given(st.text(st.characters(codec=None, exclude_categories=["Zs"]), min_size=1, max_size=30))
def test_whatever_stands_in_a_name_neither_raises_nor_reaches_the_terminal(name: str):
    said = printed(facts({"name": name}))
    assert all(c.isprintable() or c == "\n" for c in said)
    said.encode()  # no halves of characters


@pytest.mark.parametrize(
    ("said", "kept"),
    [
        *((said, False) for said in ("0", "1", "-5", "²", "x", "9" * 30)),
        *((said, True) for said in ("20", "80", "")),
    ],
)
def test_a_size_without_room_is_forgotten(said: str, kept: bool):
    environment = {"COLUMNS": said, "HOME": "/"}
    forget_unusable_size(environment)
    assert environment == ({"COLUMNS": said, "HOME": "/"} if kept else {"HOME": "/"})


SPEAKS = """
import sys
from pathlib import Path
from reflexarc.terminal.plain_console import PlainConsole, accept_every_word
accept_every_word()
PlainConsole().print("5 µs – ε \\u4e00 … end")
print("raw \\udcff", file=sys.stderr)
"""


def test_a_stream_that_takes_ascii_only_gets_stand_ins():
    environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
    done = subprocess.run([sys.executable, "-c", SPEAKS], capture_output=True, env=environment)
    assert (done.returncode, done.stdout) == (0, b"5 us - e ? ~ end\n")
    assert done.stderr == b"raw ?\n"


@pytest.mark.parametrize("words", ["info LOG", "info LOG --json", "--help", "info --help"])
def test_a_reader_that_leaves_early_changes_no_answer(words: str):
    log = str(GOLDEN)
    command = f"{sys.executable} -m reflexarc {words.replace('LOG', log)} | head -c 1"
    done = subprocess.run(
        ["bash", "-c", f"set -o pipefail; {command}"], capture_output=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, b"")
