"""Where machine code is kept on disk: in a folder named after a hash of the sources it comes from.

Numba knows a cached function by its own file alone, and does not notice that a function which it
calls, in another file, has changed: it would go on running the old world. So each state of the
sources has a folder of its own; the newest few stay.

What is kept is code, and Numba's index of it are pickles: a folder that another user made, or may
write to, is not used.

Nothing is read or written when a module is imported. Decorated functions wait until `prepare` is
called, which whoever is about to compile does; from then on what is compiled is kept.
"""

import atexit
import contextlib
import errno
import fcntl
import hashlib
import inspect
import logging
import os
import shutil
import stat
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path
from typing import IO, Any, TypeVar

import llvmlite  # type: ignore[import-untyped]  # it has no stubs
import numba

KEPT_STATES = 4
COMPILED_FROM = (
    "reflexarc_runtime/sensing",
    *(
        f"reflexarc_sim_bridge/{folder}"
        for folder in (
            "arrays",
            "evaluation/cover_profile.py",
            "evaluation/limits/horizon.py",
            "evaluation/limits/least_contacts.py",
            "motion",
            "native",
            "obstacles",
            "simulation",
            "vision",
            "worlds",
        )
    ),
    "reflexarc_baselines/history/spiking_kernel.py",
    "reflexarc_trainer/sarsa",
)
"""Folders and files that compiled code comes from, its constants included."""

_PREFIX = "compiled-"
_OWN_MODE = 0o700
_LONGEST_S, _LOOK_AGAIN_S = 300.0, 0.1

_Dispatcher = TypeVar("_Dispatcher")
_config: Any = numba.config  # its stub names no settings
_log = logging.getLogger("reflexarc")

_lock = threading.RLock()
_waiting: list[Any] = []
"""Functions that are not kept yet, because nobody has called `prepare`."""
_state = {"prepared": False}


def keep_on_disk(dispatcher: _Dispatcher) -> _Dispatcher:
    """Have what Numba compiles of a function kept, once `prepare` has been called."""
    _waiting.append(dispatcher)
    if _state["prepared"]:  # of a module that was imported later
        _enable_waiting()
    return dispatcher


def prepare() -> None:
    """Find the folder of these sources, and have all decorated functions kept there.

    To be called before anything is compiled or loaded; calling it again costs next to nothing.
    """
    _state["prepared"] = True
    _enable_waiting()


def _enable_waiting() -> None:
    with _lock:  # the setting belongs to the whole process
        folder = cache_folder() if _waiting else None
        if folder is None:
            return
        before = _config.CACHE_DIR
        _config.CACHE_DIR = str(folder)
        try:
            while _waiting:
                _waiting.pop().enable_caching()
        finally:
            _config.CACHE_DIR = before


@lru_cache(maxsize=1)
def cache_folder() -> Path | None:
    """The folder for the sources as they are now, made if need be; None if none can be made."""
    home = Path(_config.CACHE_DIR or "~/.cache/reflexarc")
    try:
        home = home.expanduser()
        folder = home / f"{_PREFIX}{source_key(COMPILED_FROM)}"
        home.mkdir(parents=True, exist_ok=True)
        folder.mkdir(mode=_OWN_MODE, exist_ok=True)
        _check_ours(folder)
        os.utime(folder)  # `touch` would call a folder that cannot be written a directory
        tempfile.TemporaryFile(dir=folder).close()
    except (OSError, RuntimeError) as error:  # of what is no home, and of a user without one
        _log.warning(
            "%s: cannot keep compiled code (%s), so each process compiles anew; "
            "NUMBA_CACHE_DIR names another folder",
            home,
            getattr(error, "strerror", None) or error,
        )
        return _folder_of_this_process()
    _forget_old_states(home)
    return folder


def _check_ours(folder: Path) -> None:
    """Check that this user made it, and that nobody else can put code into it.

    Raises:
        PermissionError: it is not so.
    """
    found = folder.stat()
    owners = {folder.lstat().st_uid, found.st_uid}  # of a link as well
    if owners != {os.geteuid()} or found.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        words = f"{folder.name} is another user's, or others can write to it"
        raise PermissionError(errno.EPERM, words)


def _folder_of_this_process() -> Path | None:
    try:
        folder = tempfile.mkdtemp(prefix="reflexarc-compiled-")
    except OSError:
        return None
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(folder)


def is_kept(function: Callable[..., Any]) -> bool:
    """Whether a function's machine code is on disk."""
    folder = cache_folder()
    if folder is None:
        return False
    # Numba's own names: a folder for the module's folder and its path, then module, function, line.
    source = Path(inspect.getfile(inspect.unwrap(function)))
    path = hashlib.sha1(str(source.parent.absolute()).encode()).hexdigest()
    place = f"{source.parent.name}_{path}"
    return any(folder.glob(f"{place}/{source.stem}.{function.__qualname__}-*.nbi"))


def is_shared() -> bool:
    """Whether other processes find what this one compiles, and this one what they do."""
    folder = cache_folder()
    return folder is not None and folder.name.startswith(_PREFIX)


@contextlib.contextmanager
def compiling_alone(what: str) -> Iterator[None]:
    """Within the context no other process compiles the same; who comes later finds it done.

    A process that dies lets the next one in. Where files cannot be locked, or the one that compiles
    seems stuck, all of them compile. Not to be nested.
    """
    with contextlib.ExitStack() as stack:
        folder = cache_folder()
        if folder is not None:
            with contextlib.suppress(OSError):
                _wait_for(stack.enter_context((folder / f"{what}.lock").open("w")))
        yield


def _wait_for(file: IO[str]) -> None:
    until_s = time.monotonic() + _LONGEST_S
    while time.monotonic() < until_s:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            break
        except BlockingIOError:
            time.sleep(_LOOK_AGAIN_S)


def source_key(places: tuple[str, ...]) -> str:
    """Hash over every Python file of some places, by its path and its bytes, and the compiler.

    Args:
        places: folders or files, each from a package's name on; those that are not there count for
            nothing.
    """
    digest = hashlib.sha256(f"{numba.__version__} {llvmlite.__version__}".encode())
    for place in places:
        package, _, inside = place.partition("/")
        spec = find_spec(package)
        for root in (spec.submodule_search_locations or []) if spec else []:
            start = Path(root) / inside
            for path in sorted(start.rglob("*.py")) or [start]:
                if path.is_file():
                    digest.update(f"{package}/{path.relative_to(root)}".encode())
                    digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _forget_old_states(home: Path) -> None:
    with contextlib.suppress(OSError):
        states = sorted(home.glob(f"{_PREFIX}*"), key=lambda path: path.stat().st_mtime)
        for state in states[:-KEPT_STATES]:
            shutil.rmtree(state, ignore_errors=True)


def has_compiled() -> bool:
    """Whether anything was kept so far."""
    folder = cache_folder()
    return folder is not None and next(folder.rglob("*.nbc"), None) is not None
