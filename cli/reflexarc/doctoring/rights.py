"""Which of the settings of `--realtime` this process would get, asked for and given back."""

import resource
from collections.abc import Iterator

from reflexarc.doctoring.check_row import CheckRow, Health, unknown, well
from reflexarc.doctoring.machine_files import number_of
from reflexarc_runtime.loop.realtime import Realtime, RealtimeSettings
from reflexarc_runtime.loop.realtime.grant import Grant


def check_rights(priority: int) -> Iterator[CheckRow]:
    """Ask for each, say it, and give it back."""
    with Realtime(RealtimeSettings(priority, whole_machine=True)) as tried:
        grants = tried.grants
    for grant in grants:
        if not grant.asked.startswith("governor"):  # the processors' own row
            yield judge_grant(grant)
    yield judge_throttling(
        number_of("/proc/sys/kernel/sched_rt_runtime_us"),
        number_of("/proc/sys/kernel/sched_rt_period_us"),
    )
    yield judge_locked(resource.getrlimit(resource.RLIMIT_MEMLOCK)[0])


def judge_grant(grant: Grant) -> CheckRow:
    """One setting."""
    name = f"right: {grant.asked.split(',')[0]}"
    if not grant.refusal:
        return well(name, "granted")
    why = "a loop wakes later without it" if grant.is_needed else "worth a little on some machines"
    found = f"refused: {grant.refusal}"
    return CheckRow(name, Health.MIND, found, why, grant.remedy)


def judge_throttling(runtime_us: int | None, period_us: int | None) -> CheckRow:
    """How much of the time the kernel leaves to real-time threads."""
    if runtime_us is None or not period_us:
        return unknown("real-time limit", "/proc/sys/kernel/sched_rt_runtime_us is not readable")
    if runtime_us == 0:
        why = "no thread may be scheduled first in, first out"
        return CheckRow(
            "real-time limit", Health.MIND, "0 %", why, "sysctl kernel.sched_rt_runtime_us=950000"
        )
    if runtime_us < 0:
        why = "a loop that hangs under SCHED_FIFO can hold a processor for ever"
        remedy = "sysctl kernel.sched_rt_runtime_us=950000"
        return CheckRow("real-time limit", Health.MIND, "none", why, remedy)
    return well("real-time limit", f"{100 * runtime_us / period_us:.0f} % of the time")


def judge_locked(limit: int) -> CheckRow:
    """How much memory may be locked."""
    if limit == resource.RLIM_INFINITY:
        return well("locked memory", "no limit")
    return well("locked memory", f"limit {limit / 1024:.0f} KiB, for who has no CAP_IPC_LOCK")
