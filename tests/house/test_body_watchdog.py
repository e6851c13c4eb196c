from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.decision import Command, Input, Verdict, drive_command, safe_command
from support.body_watchdog import Watchdog

STOP = Action("stop", 0.0, 0.0)
GO = Action("left", 1.0, 1.0)
DRIVE = drive_command(4, 1, GO, Input(9, 1000, 0, 0), valid_for_ns=100)


def obeyed(command: Command, now_ns: int) -> Command | None:
    return Watchdog(STOP).heard(command).obeyed(now_ns)


def test_nothing_heard_nothing_obeyed():
    assert Watchdog(STOP).obeyed(0) is None


def test_a_drive_command_holds_until_its_input_is_too_old():
    assert obeyed(DRIVE, 1000) is DRIVE
    assert obeyed(DRIVE, 1099) is DRIVE
    assert obeyed(DRIVE, 1100) is None


def test_a_command_from_the_future_is_not_obeyed():
    assert obeyed(DRIVE, 999) is None


def test_a_safe_command_is_always_obeyed():
    safe = safe_command(5, Verdict.STALE_INPUT, STOP)
    assert obeyed(safe, 10**18) is safe


def test_the_last_command_counts():
    safe = safe_command(5, Verdict.STOPPED, STOP)
    assert Watchdog(STOP).heard(DRIVE).heard(safe).obeyed(1000) is safe
