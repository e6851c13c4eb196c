"""What a person sees while something is compiled."""

import os
import pty
import subprocess
import sys
import time

from reflexarc.terminal import compilation
from reflexarc.terminal.compilation import saying, show_compilation
from reflexarc_sim_bridge.native.compile_progress import compilation as compiling
from reflexarc_sim_bridge.native.compile_progress import watched_by

SLOW = """
import time
from reflexarc.terminal.compilation import show_compilation
from reflexarc_sim_bridge.native.compile_progress import compilation
parts = {"what agents see": 6.0}
with show_compilation(), compilation(parts) as begun, begun.part("what agents see"):
    time.sleep(1.2)
print("done")
"""


def test_a_line_says_what_is_compiled_and_for_how_long_and_goes_at_the_end(monkeypatch) -> None:
    monkeypatch.setattr(compilation, "_PERIOD_S", 0.01)
    said: list[str] = []
    watched, parts = watched_by(saying(said.append)), {"how agents move": 9.0}
    with watched, compiling(parts) as begun, begun.part("how agents move"):
        while not said:
            time.sleep(0.01)
    assert said[0] == "compiling how agents move (once for this version): 9 s left"
    assert said[-1] == ""


def test_where_nobody_looks_nothing_is_said(capsys) -> None:
    parts = {"how agents move": 9.0}
    with show_compilation(), compiling(parts) as begun, begun.part("how agents move"):
        time.sleep(0.01)
    assert capsys.readouterr().err == ""


def test_a_terminal_shows_the_line_and_is_clean_afterwards() -> None:
    outside, inside = pty.openpty()
    with subprocess.Popen(
        [sys.executable, "-c", SLOW], stderr=inside, stdout=subprocess.PIPE
    ) as run:
        os.close(inside)
        assert run.stdout is not None
        assert run.stdout.read() == b"done\n"
    shown = os.read(outside, 1 << 16).decode()
    os.close(outside)
    assert (
        "compiling what agents see (once for this version): 6 s left" in shown
        or "5 s left" in shown
    )
    assert shown.endswith("\r\x1b[2K")
