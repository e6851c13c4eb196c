"""Keys at a real (pseudo) terminal."""

import os
import subprocess
import sys
import termios
from collections.abc import Iterator

import pytest

CHILD = """
import fcntl, sys, termios, time
fcntl.ioctl(0, termios.TIOCSCTTY, 0)
from reflexarc.terminal.keyboard import Keys
try:
    with Keys() as keys:
        print("ready", flush=True)
        while not keys.is_paused():
            time.sleep(0.005)
        print("paused", flush=True)
        while keys.is_paused() and not keys.wants_to_quit():
            time.sleep(0.005)
        print("quit" if keys.wants_to_quit() else "going on", flush=True)
        if len(sys.argv) > 1:
            raise RuntimeError("broken on purpose")
except RuntimeError:
    print("failed", flush=True)
"""


@pytest.fixture
def terminal() -> Iterator[tuple[int, int]]:
    """Both ends: what the person holds, and what the program sees."""
    hand, screen = os.openpty()
    yield hand, screen
    os.close(hand)
    os.close(screen)


def child(screen: int, *words: str) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [sys.executable, "-c", CHILD, *words],
        stdin=screen,
        stdout=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


@pytest.mark.parametrize(
    ("words", "key", "said"),
    [((), b" ", "going on\n"), ((), b"q", "quit\n"), (("fail",), b"q", "quit\nfailed\n")],
)
def test_space_pauses_q_quits_and_the_terminal_is_given_back(
    terminal: tuple[int, int], words: tuple[str, ...], key: bytes, said: str
):
    hand, screen = terminal
    before = termios.tcgetattr(screen)
    with child(screen, *words) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
        assert not termios.tcgetattr(screen)[3] & (termios.ECHO | termios.ICANON)
        os.write(hand, b"x ")
        assert process.stdout.readline() == "paused\n"
        os.write(hand, key)
        assert process.stdout.read() == said
    assert process.returncode == 0
    assert termios.tcgetattr(screen) == before


def test_without_a_terminal_nobody_can_press_a_key():
    code = (
        "from reflexarc.terminal.keyboard import Keys\n"
        "with Keys() as keys:\n"
        "    print(keys.is_paused(), keys.wants_to_quit())"
    )
    for stdin in (subprocess.DEVNULL, subprocess.PIPE):
        done = subprocess.run(
            [sys.executable, "-c", code], stdin=stdin, capture_output=True, text=True, check=True
        )
        assert done.stdout == "False False\n"
