"""Names from outside, shown and pasted."""

import os
import subprocess
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_runtime.words.shown import plain, shown
from reflexarc_runtime.words.suggestion import pasteable

NAMES = ["a b.mcap", "it's", "$(id)", "`id`", "a;b", "*", "~", "new\nline", "\x1b[31m", "\\", ""]


def test_what_cannot_be_seen_is_an_escape_and_lines_stay_lines():
    assert shown("a\x1b[31m\udcff\nb\u202e") == "a\\x1b[31m\\udcff\nb\\u202e"
    assert plain("a\nb") == "a\\nb"
    assert shown("[red]µ") == "[red]µ"


@pytest.mark.parametrize("name", [*NAMES, os.fsdecode(b"\xff'\\n")])
def test_what_is_pasted_is_the_name(name: str):
    said = subprocess.run(
        ["bash", "-c", f"printf '%s\\0' {pasteable(Path('reflexarc'), name)}"],
        capture_output=True,
        check=True,
    ).stdout
    assert said == b"reflexarc\0" + os.fsencode(name) + b"\0"


@given(st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=20))
def test_a_suggestion_is_one_line_that_a_terminal_bears(name: str):
    assert pasteable("x", name).isprintable()


def test_a_file_that_looks_like_a_flag_is_a_path():
    assert pasteable("reflexarc", "info", Path("-x"), "--json") == "reflexarc info ./-x --json"
