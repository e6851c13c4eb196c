import ast
import fcntl
import importlib
import os
import pkgutil
import select
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import CodeType

import numba
import pytest
from numba.core.dispatcher import Dispatcher

from reflexarc_sim_bridge.native.cache import (
    COMPILED_FROM,
    cache_folder,
    compiling_alone,
    keep_on_disk,
    prepare,
    source_key,
)


@pytest.fixture
def sources(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package of one file in place of ours."""

    def find(name: str) -> ModuleSpec:
        spec = ModuleSpec(name, None, is_package=True)
        spec.submodule_search_locations = [str(tmp_path)]
        return spec

    monkeypatch.setattr("reflexarc_sim_bridge.native.cache.find_spec", find)
    (tmp_path / "motion.py").write_text("speed = 1")
    return tmp_path


def test_any_edit_of_a_source_gives_another_key(sources: Path):
    before = source_key(("package",))
    assert source_key(("package",)) == before
    (sources / "motion.py").write_text("speed = 2")
    assert source_key(("package",)) != before


def test_a_file_that_goes_elsewhere_gives_another_key(sources: Path):
    before = source_key(("package",))
    (sources / "folder").mkdir()
    (sources / "motion.py").rename(sources / "folder" / "motion.py")
    assert source_key(("package",)) != before


def test_an_edit_outside_of_the_named_places_compiles_nothing_anew(sources: Path):
    before = source_key(("package/motion.py", "package/none"))
    (sources / "report.py").write_text('"""What a report says, in other words."""')
    assert source_key(("package/motion.py", "package/none")) == before


def test_numba_s_own_folder_is_given_back():
    before = numba.config.CACHE_DIR
    doubled = keep_on_disk(numba.njit(lambda x: 2 * x))
    prepare()
    assert doubled.stats.cache_path.startswith(str(cache_folder()))
    assert before == numba.config.CACHE_DIR


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Where compiled code is kept, as if nobody had asked before."""
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path / "cache"))
    cache_folder.cache_clear()
    yield tmp_path / "cache"
    cache_folder.cache_clear()


def asked_again() -> Path:
    cache_folder.cache_clear()
    folder = cache_folder()
    assert folder is not None
    return folder


def test_the_folder_is_its_owner_s_alone_whatever_the_umask(home: Path):
    before = os.umask(0)
    try:
        folder = asked_again()
    finally:
        os.umask(before)
    assert folder.parent == home
    assert folder.stat().st_mode & 0o777 == 0o700
    assert asked_again() == folder
    folder.chmod(0o755)  # others may read what is no secret
    assert asked_again() == folder


@pytest.mark.parametrize("mode", [0o770, 0o702, 0o777])
def test_a_folder_that_others_can_write_to_is_not_used(
    mode: int, home: Path, caplog: pytest.LogCaptureFixture
):
    folder = asked_again()
    folder.chmod(mode)
    assert asked_again().parent != home
    assert "others can write to it" in caplog.text
    assert folder.is_dir()


def test_a_folder_or_a_link_of_somebody_else_is_not_used(
    home: Path, monkeypatch: pytest.MonkeyPatch
):
    folder = asked_again()
    monkeypatch.setattr(os, "geteuid", lambda: folder.stat().st_uid + 1)
    assert asked_again().parent != home


def test_a_link_to_a_folder_that_others_can_write_to_is_not_used(home: Path, tmp_path: Path):
    folder = asked_again()
    folder.rmdir()
    (tmp_path / "theirs").mkdir(mode=0o700)
    folder.symlink_to(tmp_path / "theirs")
    assert asked_again() == folder
    (tmp_path / "theirs").chmod(0o777)
    assert asked_again().parent != home


def test_all_that_is_compiled_comes_from_the_named_places():
    """What is imported from elsewhere are types, and no functions."""
    import_all_rooms()
    for dispatcher in dispatchers():
        function = dispatcher.py_func
        assert is_named(function.__module__), function.__module__
        for name in names_used_by(function.__code__):
            value = function.__globals__.get(name)
            module = getattr(value, "__module__", None) or ""
            if module.startswith("reflexarc"):
                assert is_named(module), f"{function.__module__}: {name} of {module}"


def test_constants_of_compiled_code_come_from_the_named_places():
    import_all_rooms()
    for module in {sys.modules[each.py_func.__module__] for each in dispatchers()}:
        used = {
            name
            for each in dispatchers()
            if each.py_func.__module__ == module.__name__
            for name in names_used_by(each.py_func.__code__)
        }
        for node in ast.parse(Path(str(module.__file__)).read_text()).body:
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("reflexarc"):
                names = {alias.asname or alias.name for alias in node.names}
                assert is_named(str(node.module)) or not names & used, (module, node.module)


def is_named(module: str) -> bool:
    """Whether the cache's key covers a module."""
    path = module.replace(".", "/")
    return any(
        path == place.removesuffix(".py") or path.startswith(f"{place}/") for place in COMPILED_FROM
    )


def names_used_by(code: CodeType) -> set[str]:
    inner = [each for each in code.co_consts if isinstance(each, CodeType)]
    return set(code.co_names).union(*map(names_used_by, inner))


def dispatchers() -> list[Dispatcher]:
    """Every function of ours that Numba compiles."""
    modules = [m for name, m in list(sys.modules.items()) if name.startswith("reflexarc")]
    found = [value for module in modules for value in vars(module).values()]
    ours = [value for value in found if isinstance(value, Dispatcher)]
    assert len(ours) > 100
    return [each for each in ours if each.py_func.__module__.startswith("reflexarc")]


def import_all_rooms() -> None:
    for room in ("reflexarc_sim_bridge", "reflexarc_trainer"):
        package = importlib.import_module(room)
        for module in pkgutil.walk_packages(package.__path__, f"{room}."):
            importlib.import_module(module.name)


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


KEPT = """
from reflexarc_sim_bridge.native.cache import is_kept, is_shared, prepare
from reflexarc_sim_bridge.native.intrinsics import whole
from reflexarc_sim_bridge.simulation.step import advance
prepare()
before = is_kept(whole)
whole(1)
print(before, is_kept(whole), is_kept(advance), is_shared())
"""


def asked(script: str, cache: Path | str, **more: str) -> str:
    """What a process prints that keeps its compiled code there."""
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(cache), **more}
    done = subprocess.run(
        [sys.executable, "-c", script], env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_a_function_is_kept_once_it_has_been_compiled(tmp_path: Path):
    assert asked(KEPT, tmp_path) == "False True False True"
    assert asked(KEPT, tmp_path) == "True True False True"


def test_where_nothing_can_be_kept_for_others_none_is_asked_to_compile():
    assert asked(KEPT, "/proc/self/none") == "False True False False"


def test_where_nothing_at_all_can_be_written_it_compiles_and_keeps_nothing():
    nowhere = "import tempfile\ntempfile.mkdtemp = tempfile.TemporaryFile = refuse\n"
    refuse = "def refuse(*_, **__):\n    raise OSError('nowhere')\n"
    assert asked(refuse + nowhere + KEPT, "/proc/self/none") == "False False False False"


def test_a_user_without_a_home_is_said_in_one_line():
    environment = {k: v for k, v in os.environ.items() if k not in ("HOME", "NUMBA_CACHE_DIR")}
    script = (
        "import pathlib\n"
        "def nobody(self): raise RuntimeError('Could not determine home directory.')\n"
        "pathlib.Path.expanduser = nobody\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script + KEPT], env=environment, capture_output=True, text=True
    )
    assert done.stdout.strip() == "False True False False", done.stderr
    assert done.stderr.count("\n") == 1
    assert "cannot keep compiled code (Could not determine home directory.)" in done.stderr


def test_threads_that_prepare_at_once_give_numba_s_folder_back():
    before = numba.config.CACHE_DIR
    for _ in range(20):
        functions = [keep_on_disk(numba.njit(lambda x: x)) for _ in range(20)]
        with ThreadPoolExecutor(4) as pool:
            list(pool.map(lambda _: prepare(), range(8)))
        assert before == numba.config.CACHE_DIR
        folder = str(cache_folder())
        assert all(each.stats.cache_path.startswith(folder) for each in functions)


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


STEP = """
import sys
import numpy as np
from numba.core.dispatcher import Dispatcher
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.files import world_named
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from reflexarc_trainer.config.presets import PRESETS
from reflexarc_trainer.sarsa.forms import new_learner

for name in ("reference-1", "gates", "corridor-20", "automaton", "discs"):
    simulation = Simulation(world_named(name), reference_contract(), np.arange(2, dtype=np.uint64))
    simulation.step_and_sense(np.zeros(2, np.int64))
    simulation.distances()
    simulation.outlines_near(0)
for form in ("reflex", "online"):
    new_learner(PRESETS[form]).run(1)

compiled = []
for name, module in list(sys.modules.items()):
    if name.startswith("reflexarc"):
        for function in vars(module).values():
            if isinstance(function, Dispatcher):
                loaded = sum(function.stats.cache_hits.values())
                if len(function.overloads) > loaded:
                    compiled.append(function.py_func.__qualname__)
print(*sorted(set(compiled)))
"""


@pytest.mark.long
def test_what_one_process_compiled_no_other_compiles_again(tmp_path: Path):
    """Of all kinds of layers, whose modules are imported when a world needs them, and learners."""
    cache = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    command = [sys.executable, "-c", STEP]
    first, second = (
        subprocess.run(
            command, env=cache, capture_output=True, text=True, check=True
        ).stdout.split()
        for _ in range(2)
    )
    assert {"advance", "learn", "drive"} <= set(first)
    assert second == []
