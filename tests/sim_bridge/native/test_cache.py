import fcntl
import os
import select
import subprocess
import sys
from importlib.machinery import ModuleSpec
from pathlib import Path

import numba
import pytest

from reflexarc_sim_bridge.native import cache as compile_cache
from reflexarc_sim_bridge.native.cache import (
    cache_folder,
    compiling_alone,
    is_kept,
    keyed_by_sources,
    source_key,
)
from reflexarc_sim_bridge.simulation.step import advance, cover


@pytest.fixture
def sources(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package of one file in place of ours."""

    def find(name: str) -> ModuleSpec:
        spec = ModuleSpec(name, None, is_package=True)
        spec.submodule_search_locations = [str(tmp_path)]
        return spec

    monkeypatch.setattr(compile_cache, "find_spec", find)
    (tmp_path / "motion.py").write_text("speed = 1")
    return tmp_path


def test_any_edit_of_a_source_gives_another_key(sources: Path):
    before = source_key()
    assert source_key() == before
    (sources / "motion.py").write_text("speed = 2")
    assert source_key() != before


def test_numba_s_own_folder_is_given_back():
    before = numba.config.CACHE_DIR
    with keyed_by_sources():
        assert str(cache_folder()) == numba.config.CACHE_DIR
    assert before == numba.config.CACHE_DIR


def test_only_the_newest_states_are_kept(
    sources: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    home = tmp_path / "cache"
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(home))
    for age in range(6):
        old = home / f"compiled-{age}"
        old.mkdir(parents=True)
        os.utime(old, (age, age))
    cache_folder.cache_clear()
    try:
        newest = cache_folder()
    finally:
        cache_folder.cache_clear()
    kept = {path.name for path in home.iterdir()}
    assert kept == {newest.name, "compiled-5", "compiled-4", "compiled-3"}


NOWHERE = """
from reflexarc_sim_bridge.native.cache import cache_folder
(cache_folder() / "compiled").write_text("by one process")
print(cache_folder())
"""


def test_without_a_place_to_write_it_compiles_into_a_folder_that_ends_with_the_process():
    nowhere = {**os.environ, "NUMBA_CACHE_DIR": "/proc/self/none"}
    asked = subprocess.run(
        [sys.executable, "-c", NOWHERE], env=nowhere, capture_output=True, text=True
    )
    assert "reflexarc-compiled-" in asked.stdout, asked.stderr
    assert not Path(asked.stdout.strip()).exists()


def test_a_function_is_kept_once_it_has_been_compiled(
    sources: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "cache"))
    cache_folder.cache_clear()
    try:
        before = is_kept(advance)
        package = cache_folder() / "simulation_1234"
        package.mkdir()
        (package / "step.advance-7.py311.nbi").touch()
        assert (before, is_kept(advance), is_kept(cover)) == (False, True, False)
    finally:
        cache_folder.cache_clear()


def test_where_nothing_can_be_kept_no_other_process_is_asked_to_compile(
    monkeypatch: pytest.MonkeyPatch,
):
    monkeypatch.setattr(numba.config, "CACHE_DIR", "/proc/self/none")
    cache_folder.cache_clear()
    try:
        assert is_kept(advance)
        cache_folder().rmdir()
    finally:
        cache_folder.cache_clear()


HOLD = """
import sys
from reflexarc_sim_bridge.native.cache import compiling_alone
print("here", file=sys.stderr, flush=True)
with compiling_alone("world"):
    print("in", flush=True)
    sys.stdin.readline()
"""


def holder(cache: Path) -> "subprocess.Popen[str]":
    """Another process that compiles, until it is told to stop."""
    return subprocess.Popen(
        [sys.executable, "-c", HOLD],
        env={**os.environ, "NUMBA_CACHE_DIR": str(cache)},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.mark.parametrize("end", ["it is done", "it dies"])
def test_who_comes_later_waits_until_the_first_one_has_compiled(tmp_path: Path, end: str):
    with holder(tmp_path) as first, holder(tmp_path) as second:
        outputs = [first.stdout, second.stdout]
        assert [one.stderr and one.stderr.readline() for one in (first, second)] == ["here\n"] * 2
        ready, _, _ = select.select(outputs, [], [], 60.0)
        [inside] = [one for one in (first, second) if one.stdout in ready]
        waiting = second if inside is first else first
        assert not select.select([waiting.stdout], [], [], 1.0)[0], "both are in"
        if end == "it dies":
            inside.kill()
        else:
            inside.communicate("\n")
        assert waiting.communicate("\n", timeout=60.0)[0] == "in\n"


def test_where_nothing_can_be_locked_everybody_compiles(monkeypatch: pytest.MonkeyPatch):
    def no_lock(*_: object) -> None:
        raise OSError("no locks here")

    monkeypatch.setattr(fcntl, "flock", no_lock)
    with compiling_alone("world"), compiling_alone("world"):
        pass


def test_an_error_within_is_no_lock_that_fails():
    with pytest.raises(PermissionError), compiling_alone("world"):
        raise PermissionError
