"""`reflexarc …` with faults that a signal sets off: `python -m campaigns.ends.faulty run …`.

Until a signal comes, it is the command as it is. Then the next decision of a runtime, the next
twist of a bridge, or the next step of a simulated body does not return, or late. A policy file
cannot hold Python, so the fault is put where the loop asks for these.
"""

import signal
import sys
import time
from collections.abc import Callable
from types import FrameType
from typing import Any

import numpy as np

from campaigns.ends.kinds import FAULTS, HANG_NUMPY, HANG_ONNX, HANG_PYTHON
from reflexarc.main import main

HOLD_S = 0.2
SPECIAL = 200
"""Intensity of a retina at which the looping policy never returns."""
_FOR_EVER = 1 << 40
_TRIED = 200_000

_pending: list[int] = []
_a_hold = 0
"""Numbers that NumPy adds up in `HOLD_S`."""


def hold_lock(numbers: int) -> None:
    """Add up so many Python numbers in one call of NumPy's: no other thread runs meanwhile."""
    np.broadcast_to(np.array(1, object), (numbers,)).sum()


def suffer(fed: tuple[Any, ...] = ()) -> tuple[Any, ...]:
    """Do what a signal asked for, once; what the loop goes on with."""
    if not _pending:
        return fed
    number = _pending.pop()
    if number == HANG_PYTHON:
        while True:
            pass
    if number == HANG_ONNX:
        return (np.full_like(fed[0], SPECIAL), *fed[1:])
    hold_lock(_FOR_EVER if number == HANG_NUMPY else _a_hold)
    return fed


def harm(owner: type, name: str, *, is_fed: bool = False) -> None:
    """Let a method suffer before it does what it does.

    Args:
        owner: its class.
        name: its name.
        is_fed: whether its arguments may be replaced.
    """
    whole: Callable[..., Any] = getattr(owner, name)

    def harmed(self: Any, *arguments: Any) -> Any:
        return whole(self, *(suffer(arguments) if is_fed else (suffer(), arguments)[1]))

    setattr(owner, name, harmed)


def _prepare(command: str) -> None:
    global _a_hold
    if command == "run":
        from reflexarc_runtime.policy.policy import LoadedPolicy

        harm(LoadedPolicy, "decide", is_fed=True)
    elif command == "ros2":
        from reflexarc_sim_bridge.body.ros2.command_relay import CommandRelay

        harm(CommandRelay, "speak")
    else:
        from reflexarc_sim_bridge.body.body import Body

        harm(Body, "move")
    begun = time.process_time()
    hold_lock(_TRIED)
    _a_hold = round(_TRIED * HOLD_S / max(1e-4, time.process_time() - begun))
    for number in FAULTS:
        signal.signal(number, _note)


def _note(number: int, frame: FrameType | None) -> None:
    _pending.append(number)


if __name__ == "__main__":
    _prepare(sys.argv[1])
    sys.exit(main(sys.argv[1:]))
