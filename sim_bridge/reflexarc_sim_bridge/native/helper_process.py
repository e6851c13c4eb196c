"""A second process that compiles one thing while this process compiles another.

Numba compiles one function at a time, so a thread would not help. What the other process compiles
it leaves in the cache, where this one finds it. If it fails, this one compiles all. The two hand
types over as pickles, through a pipe that nobody else writes to.
"""

import contextlib
import os
import pickle
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from importlib import import_module
from typing import Any

from reflexarc_sim_bridge.native.cache import prepare
from reflexarc_sim_bridge.native.numba_compiler import without_garbage_collection

_LONGEST_S = 300.0
"""A process that takes longer is stuck."""
_LOOK_AGAIN_S = 0.5


def has_room() -> bool:
    """Whether a second processor is available."""
    return len(os.sched_getaffinity(0)) > 1


@contextlib.contextmanager
def compiled_meanwhile(function: Any, types: tuple[Any, ...]) -> Iterator[None]:
    """Within it another process compiles a function; afterwards it is in the cache.

    Args:
        function: a compiled one, at the top level of its module.
        types: numba's, of its arguments.
    """
    with at_work(__name__, pickle.dumps((function.__module__, function.__name__, types))):
        yield


@contextlib.contextmanager
def at_work(module: str, given: bytes) -> Iterator[None]:
    """Within it, and until it has ended, a process runs a module of ours.

    Args:
        module: its name.
        given: what it reads on its standard input.
    """
    helper = start(module, given)
    try:
        yield
        if helper:
            with contextlib.suppress(subprocess.TimeoutExpired):
                helper.wait(_LONGEST_S)
    finally:
        if helper:
            _stop(helper)


def start(module: str, given: bytes) -> subprocess.Popen[bytes] | None:
    """Start a helper process; None if the system refuses."""
    command, silent = [sys.executable, "-P", "-m", module], subprocess.DEVNULL
    try:
        helper = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=silent, stderr=silent)
    except OSError:
        return None
    assert helper.stdin is not None, "a pipe was asked for"
    with contextlib.suppress(BrokenPipeError), helper.stdin as pipe:
        pipe.write(given)
    return helper


def end_with_parent() -> None:
    """From now on this process, the second one, ends where the first one does."""
    threading.Thread(target=_watch, args=(os.getppid(),), daemon=True).start()


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(_LOOK_AGAIN_S)
    os._exit(1)


def _stop(helper: subprocess.Popen[bytes]) -> None:
    helper.kill()
    helper.wait()


def main() -> None:
    """The other process: module, function and types come in on standard input, as a pickle."""
    try:
        module, name, types = pickle.load(sys.stdin.buffer)
        function = getattr(import_module(module), name)
    except Exception as error:  # a pickle of garbage can raise anything
        print(
            f"helper_process: expected a pickled call on standard input: {error}",
            file=sys.stderr,
        )
        raise SystemExit(2) from None
    end_with_parent()
    prepare()
    with without_garbage_collection():
        function.compile(types)


if __name__ == "__main__":
    main()
