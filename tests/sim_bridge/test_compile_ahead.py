"""A second process that compiles: what it leaves, and what it makes of anything else."""

import io
import os
import pickle
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest

from reflexarc_sim_bridge import compile_ahead
from reflexarc_sim_bridge.random_numbers import uniform

AHEAD = [sys.executable, "-m", "reflexarc_sim_bridge.compile_ahead"]
ASK = """
import numba
import numpy as np
from reflexarc_sim_bridge.random_numbers import uniform
uniform.compile((numba.uint64,))
print(sum(uniform.stats.cache_hits.values()))
"""


def test_another_process_finds_what_one_has_compiled(tmp_path: Path):
    cache = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    call = pickle.dumps(("reflexarc_sim_bridge.random_numbers", "uniform", (numba.uint64,)))
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
        compile_ahead.main()
    assert ended.value.code == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_what_only_compiled_code_can_call_refuses_python():
    for _ in range(2):  # before it is compiled, and after
        with pytest.raises(TypeError, match="uniform: only compiled functions can call it"):
            uniform(np.uint64(1))
        uniform.compile((numba.uint64,))  # type: ignore[attr-defined]  # numba's
