"""The process in which a policy watches a loop: see `shadow`.

    python -m reflexarc_runtime.loop.candidates.shadow_process SOCKET POLICY BACKEND

It ends when the loop's end of the socket is closed, and with the process that started it.
"""

import ctypes
import importlib
import os
import signal
import socket
import sys
from contextlib import suppress
from pathlib import Path

from reflexarc_runtime.loop.candidates.shadow_wire import READY, pack_answer, unpack_tick
from reflexarc_runtime.loop.trials.trial_process import limit_memory
from reflexarc_runtime.policy.policy import Backend, load_policy
from reflexarc_runtime.serving.shadowing import ShadowMind

NICE = 10
"""The loop and the body come first."""
_MOST_TICK_BYTES = 1 << 21
_PR_SET_PDEATHSIG = 1


def main(descriptor: int, path: Path, backend: str) -> None:
    """Watch until the socket is closed."""
    _end_with_the_loop()
    if backend == Backend.ONNXRUNTIME:
        importlib.import_module("reflexarc_runtime.policy.onnxruntime_backend")
    limit_memory(path.stat().st_size)
    mind = ShadowMind(load_policy(path, backend, bounds=None))
    with socket.socket(fileno=descriptor) as link, suppress(BrokenPipeError, ConnectionError):
        link.send(READY)
        while data := link.recv(_MOST_TICK_BYTES):
            link.send(pack_answer(mind.decide(unpack_tick(data))))


def _end_with_the_loop() -> None:
    """A signal for the whole group is the loop's to answer; its death is this one's."""
    for each in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT):
        signal.signal(each, signal.SIG_IGN)
    with suppress(AttributeError, OSError):
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL, 0, 0, 0)
    with suppress(OSError):
        os.nice(NICE)
    with suppress(AttributeError, OSError):  # else it interrupts the loop that has just woken it
        os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))


if __name__ == "__main__":
    main(int(sys.argv[1]), Path(sys.argv[2]), sys.argv[3])
