"""The ends that a drive may come to: what happens to which process, and what is promised then.

Two set-ups. `bus`: `reflexarc sim` is the body, `reflexarc run` its runtime. `ros2`: a robot that
speaks ROS 2 (a router, a scanner, wheels), `reflexarc ros2` with its companion, `reflexarc run`.

The bounds are sums of what the documentation promises, from the end of a process to the moment at
which its robot is told to stand:

- whoever drives does so by one scan or retina, for as long as the command is valid (100 ms) on the
  body's clock, and the body looks once a period (20 ms);
- a runtime takes an input for 100 ms, and looks once a tick (20 ms);
- a bridge that is asked to end says standstill within its period (20 ms);
- the companion of one that is gone or silent says it after two periods (40 ms);
- and a message needs its way: `TRAVEL_MS` for all of it.
"""

import signal
from dataclasses import dataclass, replace
from typing import Literal

Place = Literal["bus", "ros2"]
Victim = Literal["runtime", "body", "scanner", "bridge", "companion", "bridge and companion"]

PERIOD_MS = 20.0
"""Of the body, of the bridge and of the runtime: 50 Hz."""
VALID_MS = 100.0
"""A command's validity, and the oldest input that a runtime decides on: the contract's default."""
TRAVEL_MS = 10.0
"""Two messages through Zenoh on one machine, and who waits for them being woken."""

TIMED_OUT = -signal.SIGALRM
KILLED = -signal.SIGKILL


@dataclass(frozen=True)
class Blow:
    """What is done to a process."""

    name: str
    number: int
    """The signal that does it; those that cause a hang are heard by `faulty.py`."""
    lasts_s: tuple[float, float] = (0.8, 1.0)
    """How long the robot is watched before anything else happens: least, most."""
    statuses: tuple[int | None, ...] = (None,)
    """How the process may end by that; None: it goes on."""
    resumes: Literal["asked", "alone", "never"] = "never"
    """Whether it goes on: by SIGCONT at the end of that time, by itself within it, or not."""


_LONG = (0.8, 1.5)
HANG_PYTHON, HANG_NUMPY, HOLD_NUMPY, HANG_ONNX = (
    signal.SIGUSR1,
    signal.SIGUSR2,
    signal.SIGRTMIN,
    signal.SIGRTMIN + 1,
)
FAULTS = (HANG_PYTHON, HANG_NUMPY, HOLD_NUMPY, HANG_ONNX)
KILL = Blow("SIGKILL", signal.SIGKILL, statuses=(KILLED,))
ASKED = tuple(
    Blow(number.name, number, statuses=(0,))
    for number in (signal.SIGHUP, signal.SIGTERM, signal.SIGQUIT)
)
STOP = Blow("SIGSTOP", signal.SIGSTOP, _LONG, resumes="asked")
SHORT_STOP = Blow(
    "SIGSTOP, < 0.4 s", signal.SIGSTOP, (0.15, 0.4), (None, TIMED_OUT), resumes="asked"
)
LONG_STOP = Blow("SIGSTOP, > 0.8 s", signal.SIGSTOP, _LONG, (TIMED_OUT,), resumes="asked")
HELD = Blow("NumPy holds the lock 0.2 s", HOLD_NUMPY, statuses=(None, TIMED_OUT), resumes="alone")
ONNX = Blow("hangs in onnxruntime", HANG_ONNX, resumes="alone")
PYTHON = Blow("hangs in Python", HANG_PYTHON, statuses=(KILLED,))
NUMPY = Blow("hangs in NumPy", HANG_NUMPY, statuses=(KILLED,))
TIMED_PYTHON = Blow("hangs in Python", HANG_PYTHON, statuses=(TIMED_OUT,))
TIMED_NUMPY = Blow("hangs in NumPy", HANG_NUMPY, statuses=(TIMED_OUT,))


@dataclass(frozen=True)
class Kind:
    """One way for a drive to end."""

    place: Place
    victim: Victim
    blow: Blow
    bound_ms: float | None
    """Until the robot is told to stand; None: nothing is promised."""
    drives_on: bool = False
    """Whether the robot shall not even notice."""

    @property
    def name(self) -> str:
        """As a row of the table begins."""
        return f"{self.place}, {self.victim}: {self.blow.name}"

    @property
    def is_quick(self) -> bool:
        """Whether the process goes on before a robot with inertia has come to a standstill."""
        return self.blow.resumes == "alone" or self.blow.lasts_s[1] < 0.5

    def works_on(self, backend: str) -> bool:
        """Whether a runtime with this backend can come to this end."""
        return self.blow is not ONNX or backend == "onnxruntime"


_BY_VALIDITY_MS = VALID_MS + PERIOD_MS + TRAVEL_MS
_BY_COMPANION_MS = 2 * PERIOD_MS + TRAVEL_MS
_BY_FAREWELL_MS = PERIOD_MS + TRAVEL_MS


def _runtime(place: Place) -> list[Kind]:
    blows = (KILL, *ASKED, SHORT_STOP, LONG_STOP, TIMED_PYTHON, TIMED_NUMPY, HELD, ONNX)
    return [Kind(place, "runtime", blow, _BY_VALIDITY_MS) for blow in blows]


KINDS: tuple[Kind, ...] = (
    *_runtime("bus"),
    *(
        Kind("bus", "body", blow, _BY_VALIDITY_MS)
        for blow in (KILL, *ASKED, STOP, PYTHON, NUMPY, HELD)
    ),
    *_runtime("ros2"),
    *(Kind("ros2", "scanner", blow, _BY_VALIDITY_MS) for blow in (KILL, STOP)),
    *(Kind("ros2", "bridge", blow, _BY_COMPANION_MS) for blow in (KILL, STOP, PYTHON, NUMPY, HELD)),
    *(Kind("ros2", "bridge", blow, _BY_FAREWELL_MS) for blow in ASKED),
    *(Kind("ros2", "companion", blow, None, drives_on=True) for blow in (KILL, STOP)),
    Kind("ros2", "bridge and companion", replace(KILL, lasts_s=(1.3, 1.5)), None),
)
