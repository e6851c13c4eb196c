"""The process that tries a policy file: see `trial`.

    python -m reflexarc_runtime.loop.trials.trial_process POLICY BACKEND [-]

With `-` the bytes come on its standard input, and POLICY is but what they are called. It prints
`ready` when it has loaded its own modules, then one JSON object.
"""

import importlib
import json
import resource
import signal
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from statistics import median

import numpy as np

from reflexarc_runtime.errors import PolicyError, ReflexarcError
from reflexarc_runtime.loop.clock import MonotonicClock
from reflexarc_runtime.loop.trials.trial import (
    DECISIONS,
    MEMORY_BYTES,
    PER_BYTE,
    READY,
    STDIN,
    Finding,
)
from reflexarc_runtime.policy.golden_check import start_of
from reflexarc_runtime.policy.model_file import MAX_FILE_BYTES
from reflexarc_runtime.policy.policy import Backend, LoadedPolicy, load_policy

UNTIMED = 4
"""Decisions before the first one that is measured."""
LONGEST_NS = 1_000_000_000
"""After this time no further decision is measured."""
ALONE_S = 60
"""The kernel ends this process after so long, whatever became of the one that started it."""


def main(path: Path, backend: str, data: bytes | None = None) -> None:
    """Try a policy, from its file or from what was read of it, and print what was found."""
    signal.alarm(ALONE_S)
    if backend == Backend.ONNXRUNTIME:
        # Its library is none of what the policy takes, and takes its time.
        importlib.import_module("reflexarc_runtime.policy.onnxruntime_backend")
    limit_memory(_size_of(path) if data is None else len(data))
    print(READY, flush=True)
    print(json.dumps(_try(path, backend, data)))


def ask_about_darkness(policy: LoadedPolicy, name: str) -> None:
    """Ask what whoever loads it will ask it before its first tick, without a limit: see `warm_up`.

    Raises:
        PolicyError: it gives no answer.
    """
    stack = np.zeros((1, *policy.contract.retina.stack_shape), np.uint8)
    try:
        policy.graph.run(stack, start_of(policy.contract, 1))
    except PolicyError as error:
        raise PolicyError(f"{name}: no answer in darkness: {error}") from None


def measure(policy: LoadedPolicy, now_ns: Callable[[], int]) -> int:
    """Median time of a decision, nanoseconds: a batch of one, after a warm-up."""
    golden = policy.contract.golden.retinas
    stacks = [
        np.array(retina, np.uint8).reshape(1, *policy.contract.retina.stack_shape)
        for retina in golden
    ]
    memory = start_of(policy.contract, 1)
    times_ns: list[int] = []
    while len(times_ns) < UNTIMED + DECISIONS and (
        len(times_ns) <= UNTIMED or sum(times_ns) < LONGEST_NS
    ):
        began_ns = now_ns()
        policy.graph.run(stacks[len(times_ns) % len(stacks)], memory)
        times_ns.append(now_ns() - began_ns)
    return round(median(times_ns[UNTIMED:]))


def limit_memory(file_bytes: int) -> None:
    """Limit the address space to what the process has and what a policy may take, if possible.

    Args:
        file_bytes: size of the policy's file.
    """
    with suppress(OSError, ValueError):
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        limit = pages * resource.getpagesize() + MEMORY_BYTES + PER_BYTE * file_bytes
        resource.setrlimit(resource.RLIMIT_AS, (limit, resource.getrlimit(resource.RLIMIT_AS)[1]))


def _size_of(path: Path) -> int:
    """Of a file; what is none, or too large, is refused later."""
    try:
        return min(path.stat().st_size, MAX_FILE_BYTES)
    except OSError:
        return 0


def _try(path: Path, backend: str, data: bytes | None) -> dict[str, str | int]:
    try:
        source = path if data is None else data
        policy = load_policy(source, backend, bounds=None, name=str(path))
        ask_about_darkness(policy, str(path))
        return asdict(Finding(policy.policy_hash, measure(policy, MonotonicClock().now_ns)))
    except ReflexarcError as error:
        return {"error": str(error)}
    except MemoryError:
        return {"error": f"{path}: wants more than {MEMORY_BYTES >> 20} MiB of memory"}


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2], sys.stdin.buffer.read() if STDIN in sys.argv[3:] else None)
