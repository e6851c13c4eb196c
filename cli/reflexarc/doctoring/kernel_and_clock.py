"""Kernel, clocks, memory: what a loop stands on."""

import ctypes
import os
import time
from collections.abc import Iterator
from pathlib import Path

from reflexarc.doctoring.check_row import CheckRow, Health, unknown, well
from reflexarc.doctoring.machine_files import fields_of, text_of
from reflexarc_runtime.loop.bell import locks_wait_steadily

_GOOD_SOURCES = ("tsc", "arch_sys_counter", "kvm-clock", "hyperv_clocksource_tsc_page")
_TIME_ERROR = 5
_SHM_LEAST_MB = 64


def check_kernel_and_clock() -> Iterator[CheckRow]:
    """All that is said of them."""
    yield well("kernel", f"{os.uname().release}, {_preemption()}{_container()}")
    yield judge_resolution(time.clock_getres(time.CLOCK_MONOTONIC))
    yield judge_source(text_of("/sys/devices/system/clocksource/clocksource0/current_clocksource"))
    yield judge_wall_clock(_clock_state())
    yield judge_waits(is_steady=locks_wait_steadily())
    yield judge_swap(fields_of("/proc/meminfo"))
    yield _shared_memory()


def _preemption() -> str:
    if text_of("/sys/kernel/realtime") == "1":
        return "PREEMPT_RT"
    words = [word for word in os.uname().version.split() if word.startswith("PREEMPT")]
    return words[0] if words else "without preemption"


def _container() -> str:
    marks = {"/.dockerenv": "Docker", "/run/.containerenv": "Podman"}
    names = [name for path, name in marks.items() if Path(path).exists()]
    return f", in a container of {names[0]}" if names else ""


def judge_resolution(resolution_s: float) -> CheckRow:
    """How finely a timer can be set."""
    found = f"{resolution_s * 1e9:.0f} ns"
    if resolution_s <= 1e-6:
        return well("timer resolution", found)
    why = "without high-resolution timers a loop wakes at the kernel's own ticks"
    return CheckRow("timer resolution", Health.BAD, found, why, "CONFIG_HIGH_RES_TIMERS")


def judge_source(source: str | None) -> CheckRow:
    """What counts the time."""
    if source is None:
        return unknown("clock source", "/sys does not tell")
    if source in _GOOD_SOURCES:
        return well("clock source", source)
    why = "reading the time goes through the kernel, which takes a microsecond or more"
    return CheckRow("clock source", Health.MIND, source, why, "the kernel's clocksource=tsc")


def judge_wall_clock(state: int | None) -> CheckRow:
    """Whether anything keeps the wall clock right; the loop's own clock is another one."""
    if state is None:
        return unknown("wall clock", "adjtimex is refused here")
    if state != _TIME_ERROR:
        return well("wall clock", "kept right (NTP)")
    why = "logs of several machines cannot be laid side by side; the loop does not use it"
    return CheckRow("wall clock", Health.MIND, "kept right by nothing", why, "chrony, timesyncd")


def judge_waits(*, is_steady: bool) -> CheckRow:
    """Whether the time-out of a lock of Python's ends when it should though the wall clock is set.

    Loop, watchdog and recorder wait otherwise where it does not.
    """
    if is_steady:
        return well("time-outs", "by the monotonic clock")
    why = "while the wall clock is set back, notices wait; the loop's waits cost a little more"
    remedy = "a Python built on glibc 2.30 or later"
    return CheckRow("time-outs", Health.MIND, "by the wall clock", why, remedy)


def judge_swap(memory: dict[str, str]) -> CheckRow:
    """Whether memory can be taken from a process."""
    if "SwapTotal" not in memory:
        return unknown("swap", "/proc/meminfo does not tell")
    if memory["SwapTotal"].split()[0] == "0":
        return well("swap", "none")
    why = "a page that was swapped out comes back in milliseconds"
    remedy = "--realtime locks the loop's memory; or swapoff"
    return CheckRow("swap", Health.MIND, memory["SwapTotal"], why, remedy)


def _shared_memory() -> CheckRow:
    try:
        room = os.statvfs("/dev/shm")
    except OSError:
        return unknown("shared memory", "/dev/shm is not there")
    free_mb = room.f_bavail * room.f_frsize / 1e6
    found = f"{free_mb:.0f} MB free"
    if free_mb >= _SHM_LEAST_MB:
        return well("shared memory", found)
    why = "Zenoh passes large messages through it, if it is told to"
    return CheckRow("shared memory", Health.MIND, found, why, "--shm-size (container)")


class _Timex(ctypes.Structure):
    _fields_ = (("modes", ctypes.c_uint), ("rest", ctypes.c_byte * 508))  # 208 bytes, and room


def _clock_state() -> int | None:
    """What adjtimex(2) answers to a question that changes nothing."""
    try:
        state = int(ctypes.CDLL(None, use_errno=True).adjtimex(ctypes.byref(_Timex())))
    except (AttributeError, OSError):
        return None
    return None if state < 0 else state
