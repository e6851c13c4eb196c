import re
import subprocess
import sys
import tomllib
from pathlib import Path

import numba
import pytest

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.native.numba_version import CEILING, LOWEST, check_numba_version

ROOT = Path(__file__).parents[3]


@pytest.mark.parametrize("version", ["0.62.0", "0.62.1", "0.68.1", "0.68.0rc1", numba.__version__])
def test_versions_that_were_tested_are_taken(version: str) -> None:
    check_numba_version(version)


@pytest.mark.parametrize("version", ["0.61.2", "0.7", "0.69.0", "0.69.0dev0+12", "1.0.0"])
def test_others_are_refused_in_one_line(version: str) -> None:
    with pytest.raises(UsageError, match=f"^numba {re.escape(version)}: expected 0.62 or later"):
        check_numba_version(version)


def test_the_bounds_are_those_of_the_distribution() -> None:
    document = tomllib.loads((ROOT / "pyproject.toml").read_text())
    [numba_s] = [
        each
        for each in document["project"]["optional-dependencies"]["sim"]
        if each.startswith("numba")
    ]
    assert numba_s == f"numba>={LOWEST[0]}.{LOWEST[1]},<{CEILING[0]}.{CEILING[1]}"


def test_a_command_says_it_in_one_line_and_exits_with_2() -> None:
    code = """
import numba
numba.__version__ = "0.99.0"
from reflexarc.main import main
raise SystemExit(main(["worlds", "check", "reference-1"]))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
    assert done.stderr.startswith("reflexarc: numba 0.99.0: expected 0.62 or later and before 0.69")
