"""`reflexarc run` with a fault in its loop: `python -m support.hanging_runtime FAULT run …`.

A policy file cannot hold Python, so the fault is put where the loop asks its policy. It begins
at the decision of a number that is long after the start; most happen once.
"""

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

AT_DECISION = 200
"""Number of the decision in which the fault happens; a tick asks up to three times, as it is
rehearsed before its deadline, and a second has to be on the disk before."""
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
"""These happen at every decision from that number on."""


def loop_in_the_graph() -> None:
    """From that number on, the policy's graph never returns: only its runtime can end it."""
    endless = OnnxruntimeGraph(looping(PolicyContract(), FOR_EVER))
    decide, asked = LoadedPolicy.decide, [0]

    def looped(self: LoadedPolicy, *retinas: Any) -> Any:
        asked[0] += 1
        if asked[0] == AT_DECISION:
            object.__setattr__(self, "graph", endless)
        return decide(self, *retinas)

    LoadedPolicy.decide = looped  # type: ignore[method-assign]


def harm(fault: Callable[[], None], lasts: bool = False) -> None:
    """Make the policy of this process do it, once or from then on."""
    decide, asked = LoadedPolicy.decide, [0]

    def harmed(self: LoadedPolicy, *retinas: Any) -> Any:
        asked[0] += 1
        if asked[0] == AT_DECISION or (lasts and asked[0] > AT_DECISION):
            fault()
        return decide(self, *retinas)

    LoadedPolicy.decide = harmed  # type: ignore[method-assign]


if __name__ == "__main__":
    if sys.argv[1] == "graph":
        loop_in_the_graph()
    else:
        harm({**FAULTS, **LASTING}[sys.argv[1]], lasts=sys.argv[1] in LASTING)
    sys.exit(main(sys.argv[2:]))
