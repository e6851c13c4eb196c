"""What the Linux kernel can be asked for by a process that must wake on time.

Sources: sched(7), mlockall(2), prctl(2) PR_SET_TIMERSLACK, the kernel's
Documentation/power/pm_qos_interface.rst.
"""

import ctypes
import os
import resource
import struct
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

_PR_SET_TIMERSLACK = 29
_MCL_CURRENT, _MCL_FUTURE, _MCL_ONFAULT = 1, 2, 4
_CAP_IPC_LOCK = 14
_LATENCY = Path("/dev/cpu_dma_latency")
_FIRST_GOVERNOR = Path("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor")

Scheduling = tuple[int, int]
"""Policy and priority of a thread."""


class Kernel(Protocol):
    """The calls; each raises OSError where it is refused, or is not there."""

    def set_timer_slack(self, slack_ns: int) -> None:
        """How much later than asked this thread may be woken, for the sake of power."""
        ...

    def threads(self) -> dict[int, str]:
        """Every thread of this process → its name in Python, empty for others."""
        ...

    def this_thread(self) -> int:
        """The number of the thread that asks."""
        ...

    def scheduling(self, thread: int) -> Scheduling:
        """How a thread is scheduled."""
        ...

    def schedule(self, thread: int, scheduling: Scheduling) -> None:
        """Let a thread be scheduled so."""
        ...

    def processors(self, thread: int) -> set[int]:
        """Those on which a thread may run."""
        ...

    def use_processors(self, thread: int, processors: set[int]) -> None:
        """Let it run on these alone."""
        ...

    def lock_memory(self, *, future: bool) -> None:
        """Let nothing that was touched be taken from memory again."""
        ...

    def unlock_memory(self) -> None:
        """Undo it."""
        ...

    def may_lock_without_limit(self) -> bool:
        """Whether whatever is mapped later can be locked too."""
        ...

    def hold_wake_latency(self) -> int:
        """Keep processors from sleeping deeply while the handle is open."""
        ...

    def release(self, handle: int) -> None:
        """Let them sleep again."""
        ...

    def governor(self) -> str:
        """Who chooses the processors' frequency."""
        ...


class LinuxKernel:
    """See `Kernel`."""

    def __init__(self) -> None:
        self._libc = ctypes.CDLL(None, use_errno=True)

    def set_timer_slack(self, slack_ns: int) -> None:
        """See `Kernel.set_timer_slack`."""
        self._call("prctl", _PR_SET_TIMERSLACK, slack_ns, 0, 0, 0)

    def threads(self) -> dict[int, str]:
        """See `Kernel.threads`."""
        named = {thread.native_id: thread.name for thread in threading.enumerate()}
        return {int(each): named.get(int(each), "") for each in os.listdir("/proc/self/task")}

    def this_thread(self) -> int:
        """See `Kernel.this_thread`."""
        return threading.get_native_id()

    def scheduling(self, thread: int) -> Scheduling:
        """See `Kernel.scheduling`."""
        return os.sched_getscheduler(thread), os.sched_getparam(thread).sched_priority

    def schedule(self, thread: int, scheduling: Scheduling) -> None:
        """See `Kernel.schedule`."""
        policy, priority = scheduling
        os.sched_setscheduler(thread, policy, os.sched_param(priority))

    def processors(self, thread: int) -> set[int]:
        """See `Kernel.processors`."""
        return set(os.sched_getaffinity(thread))

    def use_processors(self, thread: int, processors: set[int]) -> None:
        """See `Kernel.use_processors`."""
        os.sched_setaffinity(thread, processors)

    def lock_memory(self, *, future: bool) -> None:
        """See `Kernel.lock_memory`.

        Nothing is loaded for it that was never used: the stacks of 17 threads alone are 136 MB.
        """
        self._call("mlockall", _MCL_CURRENT | _MCL_ONFAULT | (_MCL_FUTURE if future else 0))

    def unlock_memory(self) -> None:
        """See `Kernel.unlock_memory`."""
        self._call("munlockall")

    def may_lock_without_limit(self) -> bool:
        """See `Kernel.may_lock_without_limit`."""
        if resource.getrlimit(resource.RLIMIT_MEMLOCK)[0] == resource.RLIM_INFINITY:
            return True
        for line in Path("/proc/self/status").read_text().splitlines():
            if line.startswith("CapEff:"):
                return bool(int(line.split()[1], 16) >> _CAP_IPC_LOCK & 1)
        return False

    def hold_wake_latency(self) -> int:
        """See `Kernel.hold_wake_latency`."""
        handle = os.open(_LATENCY, os.O_WRONLY | os.O_CLOEXEC)
        try:
            os.write(handle, struct.pack("=i", 0))
        except OSError:
            os.close(handle)
            raise
        return handle

    def release(self, handle: int) -> None:
        """See `Kernel.release`."""
        os.close(handle)

    def governor(self) -> str:
        """See `Kernel.governor`."""
        return _FIRST_GOVERNOR.read_text().strip()

    def _call(self, name: str, *arguments: int) -> None:
        try:
            call = getattr(self._libc, name)
        except AttributeError:
            raise OSError(f"no {name} in this C library") from None
        words: Sequence[ctypes.c_ulong] = [ctypes.c_ulong(each) for each in arguments]
        if call(*words):
            error = ctypes.get_errno()
            raise OSError(error, os.strerror(error))
