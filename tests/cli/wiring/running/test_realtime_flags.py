import pytest

from reflexarc.wiring.running.realtime_flags import RealtimeFlags
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.loop.realtime import RealtimeSettings


@pytest.mark.parametrize(
    ("flags", "asked"),
    [
        (RealtimeFlags(), RealtimeSettings()),
        (RealtimeFlags(fifo=20), RealtimeSettings(20)),
        (RealtimeFlags("warn"), RealtimeSettings(50, (), whole_machine=True)),
        (RealtimeFlags("strict", 7, (2,)), RealtimeSettings(7, (2,), True, True)),
    ],
)
def test_the_flags_ask_for_what_they_name(flags: RealtimeFlags, asked: RealtimeSettings):
    assert flags.settings == asked


@pytest.mark.parametrize(
    ("flags", "lockstep", "words"),
    [
        (RealtimeFlags(fifo=99), False, "--fifo: expected 0 to 98 .the watchdog.*, got 99"),
        (RealtimeFlags(fifo=-1), False, "--fifo: expected 0 to 98 .*, got -1"),
        (RealtimeFlags(cpu=(-1,)), False, "--cpu: expected numbers of processors"),
        (RealtimeFlags(cpu=(10**9,)), False, "--cpu: expected below 4096"),
        (RealtimeFlags("warn"), True, "not with --lockstep"),
        (RealtimeFlags("strict", cpu=(4095,)), False, r"--realtime strict: .*processor 4095"),
    ],
)
def test_flags_that_cannot_be_are_refused(flags: RealtimeFlags, lockstep: bool, words: str):
    with pytest.raises(UsageError, match=words):
        flags.check(lockstep=lockstep)


@pytest.mark.parametrize(("fifo", "highest"), [(0, 0), (50, 51), (98, 99)])
def test_a_service_may_take_the_priority_of_its_watchdog(fifo: int, highest: int):
    assert RealtimeFlags(fifo=fifo).settings.highest_priority == highest
