"""The processors: how many, how much of them, how fast, and who else takes of them."""

import os
from collections.abc import Iterator
from pathlib import Path

from reflexarc.doctoring.check_row import CheckRow, Health, unknown, well
from reflexarc.doctoring.machine_files import text_of

MOST_STOLEN = 0.005
"""Share of a processor's time that a hypervisor may take before it is worth a word."""


def check_processors(stolen: float | None) -> Iterator[CheckRow]:
    """All that is said of them.

    Args:
        stolen: share of the time that a hypervisor took while it was measured; None: not told.
    """
    yield _count(len(os.sched_getaffinity(0)), os.cpu_count() or 0, os.getloadavg()[0])
    yield judge_quota(_quota_of_group())
    yield judge_governor(text_of("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor"))
    yield judge_steal(stolen)


def _count(allowed: int, present: int, load: float) -> CheckRow:
    words = f"{allowed} of {present} may be used, load {load:.1f}"
    if load <= allowed:
        return well("processors", words)
    why = "more work is ready than there are processors: who has no priority waits its turn"
    return CheckRow("processors", Health.MIND, words, why, "--realtime, or less work")


def judge_quota(quota: str | None) -> CheckRow:
    """What the control group may use: `MAX PERIOD` in microseconds, as cpu.max has it."""
    words = (quota or "").split()
    if not words:
        return well("processor quota", "no control group limits it")
    if words[0] in ("max", "-1"):
        return well("processor quota", "none")
    try:
        share = int(words[0]) / int(words[1])
    except (ValueError, IndexError, ZeroDivisionError):
        return unknown("processor quota", f"cpu.max says {quota!r}")
    why = "when it is used up, the loop stands still until the next period of the group"
    found = f"{share:g} processors, {words[1]} µs at a time"
    return CheckRow("processor quota", Health.MIND, found, why, "CPUQuota= (systemd), --cpus")


def judge_governor(governor: str | None) -> CheckRow:
    """Who chooses the frequency."""
    if governor is None:
        return well("governor", "none here: the machine, or its host, chooses the frequency")
    if governor == "performance":
        return well("governor", governor)
    why = "a processor that slept begins slowly: the first microseconds of each tick"
    remedy = "cpupower frequency-set -g performance"
    return CheckRow("governor", Health.MIND, governor, why, remedy)


def judge_steal(stolen: float | None) -> CheckRow:
    """What a hypervisor takes."""
    if stolen is None:
        return unknown("stolen time", "/proc/stat does not tell")
    found = f"{100 * stolen:.1f} % while it was measured"
    if stolen <= MOST_STOLEN:
        return well("stolen time", found)
    why = "the hypervisor runs others meanwhile; no priority in here changes that"
    return CheckRow("stolen time", Health.MIND, found, why, "a machine with its own processors")


def stolen_ticks() -> tuple[int, int] | None:
    """What was stolen from all processors since the start, and all their time."""
    return parse_stolen((text_of("/proc/stat") or "").partition("\n")[0])


def parse_stolen(line: str) -> tuple[int, int] | None:
    """The first line of /proc/stat: user nice system idle iowait irq softirq steal …."""
    words = line.split()[1:]
    if len(words) < 8 or not all(word.isdecimal() for word in words):
        return None
    ticks = [int(word) for word in words[:8]]
    return ticks[7], sum(ticks)


def _quota_of_group() -> str | None:
    """Of this process's own group; version 2 of control groups, else version 1."""
    for line in (text_of("/proc/self/cgroup") or "").splitlines():
        _, controllers, path = [*line.split(":", 2), "", ""][:3]
        if not controllers:
            found = text_of(Path("/sys/fs/cgroup") / path.lstrip("/") / "cpu.max")
            if found:
                return found
        if "cpu" in controllers.split(","):
            group = Path("/sys/fs/cgroup/cpu") / path.lstrip("/")
            quota, period = (text_of(group / f"cpu.cfs_{n}_us") for n in ("quota", "period"))
            if quota and period:
                return f"{quota} {period}"
    return None


def stolen_share(before: tuple[int, int] | None, after: tuple[int, int] | None) -> float | None:
    """Which share of the processors' time was stolen between two looks."""
    if before is None or after is None or after[1] <= before[1]:
        return None
    return (after[0] - before[0]) / (after[1] - before[1])
