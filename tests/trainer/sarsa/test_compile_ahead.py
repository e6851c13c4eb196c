import io
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from reflexarc_sim_bridge.native import helper_process
from reflexarc_trainer.config.presets import PRESETS
from reflexarc_trainer.sarsa import compile_ahead
from reflexarc_trainer.sarsa.compile_ahead import compile_side_by_side
from reflexarc_trainer.sarsa.online import learner as online_learner

CONFIG = PRESETS["online"]
ASK = """
import json, sys
from reflexarc_sim_bridge.native.cache import is_kept
from reflexarc_trainer.sarsa.compile_ahead import compile_learner
from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.sarsa.online.learner import drive
before = is_kept(drive)
compile_learner(TrainConfig.from_resolved(json.load(sys.stdin)))
print(before, sum(drive.stats.cache_hits.values()))
"""


@pytest.fixture(autouse=True)
def nothing_compiled_yet(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(compile_ahead, "_compiled", set())


@pytest.fixture
def empty_cache(tmp_path: Path) -> dict[str, str]:
    return {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}


def test_another_process_finds_what_one_has_compiled(
    empty_cache: dict[str, str],
):
    config = json.dumps(CONFIG.resolved())
    ahead = [sys.executable, "-m", "reflexarc_trainer.sarsa.compile_ahead"]
    subprocess.run(ahead, input=config, text=True, env=empty_cache, check=True)
    asked = subprocess.run(
        [sys.executable, "-c", ASK], input=config, text=True, env=empty_cache, capture_output=True
    )
    assert asked.stdout == "True 1\n", asked.stderr


def test_the_other_process_loads_no_torch() -> None:
    script = "import sys, reflexarc_trainer.sarsa.compile_ahead; print('torch' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.stdout == "False\n", done.stderr


@pytest.mark.parametrize("given", ["", "garbage", "[]", "null", '{"steps": 1}'])
def test_what_is_no_configuration_is_one_line_and_exit_status_2(
    given: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.setattr(sys, "stdin", io.StringIO(given))
    with pytest.raises(SystemExit) as ended:
        compile_ahead.main()
    assert ended.value.code == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_nothing_is_started_where_all_is_compiled(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(compile_ahead, "is_kept", lambda function: True)
    monkeypatch.setattr(compile_ahead, "at_work", lambda *_: pytest.fail("started"))
    compile_side_by_side(CONFIG)


def test_a_helper_that_fails_is_waited_for_and_forgotten(monkeypatch: pytest.MonkeyPatch):
    helpers = helpers_that("raise SystemExit(3)", monkeypatch)
    compile_side_by_side(CONFIG)
    assert {helper.returncode for helper in helpers} == {3}


def test_no_helper_outlives_a_world_that_cannot_be_made(monkeypatch: pytest.MonkeyPatch):
    helpers = helpers_that("import time; time.sleep(600)", monkeypatch)
    monkeypatch.setattr(compile_ahead, "Simulation", no_world)
    with pytest.raises(ValueError, match="no such world"):
        compile_side_by_side(CONFIG)
    assert [helper.returncode for helper in helpers] == [-9]


@pytest.mark.parametrize("cores", [1, 2])
def test_a_learner_is_compiled_as_no_other_process_does(
    cores: int, monkeypatch: pytest.MonkeyPatch
):
    """With one processor, or a helper that failed, by the process that needs it."""
    helpers_that("raise SystemExit(3)", monkeypatch)
    monkeypatch.setattr(os, "sched_getaffinity", lambda pid: set(range(cores)))
    done: list[str] = []

    @contextmanager
    def alone(what: str) -> Iterator[None]:
        done.append(f"{what} locked")
        yield
        done.append("unlocked")

    monkeypatch.setattr(compile_ahead, "compiling_alone", alone)
    monkeypatch.setattr(online_learner, "compile_learner", lambda config: done.append("compiled"))
    for _ in range(2):
        compile_side_by_side(CONFIG)
    assert done == ["learner locked", "compiled", "unlocked"]


def test_a_world_that_does_not_fit_the_eye_is_refused_before_a_learner_is_compiled(
    monkeypatch: pytest.MonkeyPatch,
):
    monkeypatch.setattr(online_learner, "compile_learner", lambda _: pytest.fail("compiled"))
    monkeypatch.setattr(compile_ahead, "Simulation", no_world)
    with pytest.raises(ValueError, match="no such world"):
        compile_side_by_side(CONFIG)


def no_world(*_: object) -> None:
    raise ValueError("no such world")


def helpers_that(do: str, monkeypatch: pytest.MonkeyPatch) -> list[subprocess.Popen[str]]:
    """Helpers that do that instead, as they are started."""
    helpers: list[subprocess.Popen[str]] = []

    def start(module: str, given: bytes) -> subprocess.Popen[str]:
        helpers.append(subprocess.Popen([sys.executable, "-c", do], text=True))
        return helpers[-1]

    monkeypatch.setattr(compile_ahead, "is_kept", lambda function: False)
    monkeypatch.setattr(helper_process, "start", start)
    monkeypatch.setattr(os, "sched_getaffinity", lambda pid: {0, 1})
    return helpers
