"""The process in which a policy watches a loop: see `shadow`.

    python -m reflexarc_runtime.loop.candidates.shadow_process SOCKET BACKEND

The policy's bytes come on its standard input: the file that they were read from may be another one
by now. It ends when the loop's end of the socket is closed, and with the process that started it.
"""

import importlib
import socket
import sys
from contextlib import suppress

from reflexarc_runtime.loop.candidates.shadow_wire import READY, pack_answer, unpack_tick
from reflexarc_runtime.loop.side_process import serve_the_loop
from reflexarc_runtime.loop.trials.trial_process import limit_memory
from reflexarc_runtime.policy.policy import Backend, load_policy
from reflexarc_runtime.serving.shadowing import ShadowMind

_MOST_TICK_BYTES = 1 << 21


def main(descriptor: int, policy: bytes, backend: str) -> None:
    """Watch until the socket is closed."""
    serve_the_loop()
    if backend == Backend.ONNXRUNTIME:
        importlib.import_module("reflexarc_runtime.policy.onnxruntime_backend")
    limit_memory(len(policy))
    mind = ShadowMind(load_policy(policy, backend, bounds=None))
    with socket.socket(fileno=descriptor) as link, suppress(BrokenPipeError, ConnectionError):
        link.send(READY)
        while data := link.recv(_MOST_TICK_BYTES):
            link.send(pack_answer(mind.decide(unpack_tick(data))))


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.stdin.buffer.read(), sys.argv[2])
