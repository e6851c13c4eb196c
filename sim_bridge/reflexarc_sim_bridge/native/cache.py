"""Where compiled functions are kept: under a name made of the sources that they come from.

Numba knows a cached function by its own file alone, and does not notice that a function which it
calls, in another file, has changed: it would go on running the old world. So each state of the
sources has a folder of its own; the newest few stay.
"""

import atexit
import contextlib
import fcntl
import hashlib
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import IO, Any

import numba

KEPT_STATES = 4
_PREFIX = "compiled-"
_LONGEST_S, _LOOK_AGAIN_S = 300.0, 0.1

_config: Any = numba.config  # its stub names no settings

_SOURCES = ("reflexarc_runtime", "reflexarc_sim_bridge", "reflexarc_trainer")


@contextlib.contextmanager
def keyed_by_sources() -> Iterator[None]:
    """Within it, `numba.njit(cache=True)` keeps what it compiles in the folder of these sources."""
    before = _config.CACHE_DIR
    _config.CACHE_DIR = str(cache_folder())
    try:
        yield
    finally:
        _config.CACHE_DIR = before


@lru_cache(maxsize=1)
def cache_folder() -> Path:
    """The folder for the sources as they are now; made if need be."""
    home = Path(_config.CACHE_DIR or Path.home() / ".cache" / "reflexarc")
    folder = home / f"{_PREFIX}{source_key()}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        folder.touch()
        _forget_old_states(home)
    except OSError:
        return _folder_of_this_process()
    return folder


def _folder_of_this_process() -> Path:
    folder = tempfile.mkdtemp(prefix="reflexarc-compiled-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(folder)


def is_kept(function: Callable[..., Any]) -> bool:
    """Whether a function's compiled form is there for every process that asks.

    Where none can be kept for another one, so it is said to be.
    """
    folder = cache_folder()
    if not folder.name.startswith(_PREFIX):
        return True
    # Numba's own names: a folder for the module's folder, then module, function and line.
    package, _, module = function.__module__.rpartition(".")
    place = package.rpartition(".")[2]
    return any(folder.glob(f"{place}_*/{module}.{function.__qualname__}-*.nbi"))


@contextlib.contextmanager
def compiling_alone(what: str) -> Iterator[None]:
    """Within it no other process compiles the same; who comes later finds it done.

    Whoever dies lets the next one in. Where files cannot be locked, or one that compiles seems
    stuck, all of them compile. Not to be nested.
    """
    with contextlib.ExitStack() as stack:
        with contextlib.suppress(OSError):
            file = stack.enter_context((cache_folder() / f"{what}.lock").open("w"))
            _wait_for(file)
        yield


def _wait_for(file: IO[str]) -> None:
    until_s = time.monotonic() + _LONGEST_S
    while time.monotonic() < until_s:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            break
        except BlockingIOError:
            time.sleep(_LOOK_AGAIN_S)


def source_key() -> str:
    """Hash over every Python file that compiled code may come from."""
    digest = hashlib.sha256(numba.__version__.encode())
    for package in _SOURCES:
        spec = find_spec(package)
        for place in (spec.submodule_search_locations or []) if spec else []:
            for path in sorted(Path(place).rglob("*.py")):
                digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()[:16]


def _forget_old_states(home: Path) -> None:
    states = sorted(home.glob(f"{_PREFIX}*"), key=lambda path: path.stat().st_mtime)
    for state in states[:-KEPT_STATES]:
        shutil.rmtree(state, ignore_errors=True)
