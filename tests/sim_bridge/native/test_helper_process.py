"""A second process that compiles: what it leaves, and what it makes of anything else."""

import io
import os
import pickle
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numba
import pytest

from reflexarc_sim_bridge.native import helper_process

AHEAD = [sys.executable, "-m", "reflexarc_sim_bridge.native.helper_process"]
ASK = """
import numba
import numpy as np
from reflexarc_sim_bridge.native.cache import prepare
from reflexarc_sim_bridge.native.intrinsics import whole
prepare()
whole.compile((numba.int64,))
print(sum(whole.stats.cache_hits.values()))
"""


def test_another_process_finds_what_one_has_compiled(tmp_path: Path):
    cache = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    call = pickle.dumps(("reflexarc_sim_bridge.native.intrinsics", "whole", (numba.int64,)))
    subprocess.run(AHEAD, input=call, env=cache, check=True)
    asked = subprocess.run([sys.executable, "-c", ASK], env=cache, capture_output=True, text=True)
    assert asked.stdout == "1\n", asked.stderr


@pytest.mark.parametrize(
    "given", [b"", b"garbage", pickle.dumps(1), pickle.dumps(("no_such_module", "f", ()))]
)
def test_what_is_no_call_is_one_line_and_exit_status_2(
    given: bytes, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(given)))
    with pytest.raises(SystemExit) as ended:
        helper_process.main()
    assert ended.value.code == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_an_interrupt_while_it_is_waited_for_ends_it(monkeypatch: pytest.MonkeyPatch):
    helper = subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"])
    monkeypatch.setattr(helper_process, "start", lambda *_: helper)
    monkeypatch.setattr(helper, "wait", interrupted_once(helper.wait))
    with pytest.raises(KeyboardInterrupt), helper_process.at_work("no matter", b""):
        pass
    assert helper.returncode == -9


def interrupted_once(wait: Callable[..., int]) -> Callable[..., int]:
    waits = iter([True, False])

    def wait_or_not(*arguments: float) -> int:
        if next(waits):
            raise KeyboardInterrupt
        return wait(*arguments)

    return wait_or_not


def test_a_helper_ends_with_its_parent(tmp_path: Path):
    number = tmp_path / "helper"
    helper = (
        "import time; from reflexarc_sim_bridge.native.helper_process import end_with_parent\n"
        f"import os; end_with_parent(); open({str(number)!r}, 'w').write(str(os.getpid()))\n"
        "time.sleep(600)"
    )
    parent = (
        "import os, pathlib, subprocess, sys, time\n"
        f"subprocess.Popen([sys.executable, '-c', {helper!r}])\n"
        f"while not pathlib.Path({str(number)!r}).exists(): time.sleep(0.05)\n"
        "time.sleep(0.2); os._exit(0)"
    )
    subprocess.run([sys.executable, "-c", parent], check=True, timeout=60)
    wait_until(lambda: not Path(f"/proc/{number.read_text()}").exists())


def wait_until(happened: Callable[[], bool], longest_s: float = 20.0) -> None:
    until_s = time.monotonic() + longest_s
    while not happened():
        assert time.monotonic() < until_s
        time.sleep(0.05)
