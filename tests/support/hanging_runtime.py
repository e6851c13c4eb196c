"""`reflexarc run` with a fault in its loop: `python -m support.hanging_runtime FAULT run …`.

A policy file cannot hold Python, so the fault is put where the loop asks its policy. It begins
at the first decision after a time; most happen once.
"""

import math
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from reflexarc.main import main
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.policy.onnxruntime_backend import OnnxruntimeGraph
from reflexarc_runtime.policy.policy import LoadedPolicy
from support.looping_policies import FOR_EVER, looping

FROM_S = 1.3
"""After the first decision: a second has to be on the disk before. Decisions are not counted, as a
tick may ask several times: it is rehearsed before its deadline."""
SLOW_S = 0.08
"""Beyond the watchdog's 50 ms, and less than the age at which an input is stale."""


def slow() -> None:
    """A tick that is late, and then goes on."""
    time.sleep(SLOW_S)


def python() -> None:
    """Never returns, in Python: other threads run."""
    while True:
        pass


def numpy() -> None:
    """Holds the interpreter's lock for a second and more: no other thread runs."""
    for _ in range(10):
        np.tile(np.zeros(1 << 14), (1 << 14, 1))


class EscapingError(BaseException):
    """No `Exception`: nothing in the loop catches it."""


def escape() -> None:
    """Ends the loop from within."""
    raise EscapingError("raised in the loop")


FAULTS: dict[str, Callable[[], None]] = {
    "slow": slow,
    "python": python,
    "numpy": numpy,
    "escape": escape,
}


def three_times_a_second() -> None:
    """Every tick from now on is late."""
    time.sleep(0.33)


LASTING: dict[str, Callable[[], None]] = {"drowsy": three_times_a_second}
"""These happen at every decision from then on."""


class Fuse:
    """Says when it is time, by the time since it was asked first: once, or from then on."""

    def __init__(self, lasts: bool = False) -> None:
        self._lasts = lasts
        self._due_s: float | None = None

    def __call__(self) -> bool:
        now_s = time.monotonic()
        if self._due_s is None:
            self._due_s = now_s + FROM_S
        if now_s < self._due_s:
            return False
        self._due_s = now_s if self._lasts else math.inf
        return True


def loop_in_the_graph() -> None:
    """From then on the policy's graph never returns: only its runtime can end it."""
    endless = OnnxruntimeGraph(looping(PolicyContract(), FOR_EVER))
    decide, is_time = LoadedPolicy.decide, Fuse()

    def looped(self: LoadedPolicy, *retinas: Any) -> Any:
        if is_time():
            object.__setattr__(self, "graph", endless)
        return decide(self, *retinas)

    LoadedPolicy.decide = looped  # type: ignore[method-assign]


def harm(fault: Callable[[], None], lasts: bool = False) -> None:
    """Make the policy of this process do it, once or from then on."""
    decide, is_time = LoadedPolicy.decide, Fuse(lasts)

    def harmed(self: LoadedPolicy, *retinas: Any) -> Any:
        if is_time():
            fault()
        return decide(self, *retinas)

    LoadedPolicy.decide = harmed  # type: ignore[method-assign]


if __name__ == "__main__":
    if sys.argv[1] == "graph":
        loop_in_the_graph()
    else:
        harm({**FAULTS, **LASTING}[sys.argv[1]], lasts=sys.argv[1] in LASTING)
    sys.exit(main(sys.argv[2:]))
