"""One command by its name, against the list of all."""

import subprocess
import sys

import pytest

from reflexarc.command_groups import COMMANDS, name_of
from reflexarc.one_command import found_by_name

ELSEWHERE = {"arm", "stop", "reset", "release", "import"}
"""Commands whose files are called otherwise: these few load all of them."""


@pytest.mark.parametrize("command", COMMANDS, ids=name_of)
def test_each_is_found_by_its_name_or_is_known_to_stand_elsewhere(command: type):
    name = name_of(command)
    assert found_by_name(name) is (None if name in ELSEWHERE else command)


@pytest.mark.parametrize(
    "word", ["", "fly", "Run", "__init__", "drive", "../main", "run.py", "drive/run", "*", "sím"]
)
def test_no_other_word_finds_anything(word: str):
    assert found_by_name(word) is None


LOADED = """
import sys
from reflexarc.main import main
try:
    main(["run", "--help"])
except SystemExit:
    pass
mine = [name for name in sys.modules if name.startswith("reflexarc.commands.")]
heavy = ("numpy", "onnxruntime", "onnx", "zenoh", "mcap", "rich.progress")
print(*mine, *[name for name in heavy if name in sys.modules])
"""


def test_run_loads_no_other_command_and_nothing_heavy_before_it_runs():
    done = subprocess.run(
        [sys.executable, "-c", LOADED], capture_output=True, text=True, check=True
    )
    assert done.stdout.splitlines()[-1] == "reflexarc.commands.drive reflexarc.commands.drive.run"


NO_ONNXRUNTIME = """
import sys
import reflexarc.wiring.running.sense_act_loop, reflexarc.wiring.keeping_logs.recorders
import reflexarc_runtime.policy.policy
print("onnxruntime" in sys.modules)
"""


def test_the_loop_on_numpy_loads_no_onnxruntime():
    words = [sys.executable, "-c", NO_ONNXRUNTIME]
    assert subprocess.run(words, capture_output=True, text=True, check=True).stdout == "False\n"
