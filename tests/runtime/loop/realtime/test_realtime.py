"""What a loop asks of a kernel, on one that grants or refuses what it is told to."""

import errno
import os
import sys
from dataclasses import dataclass, field

import pytest

from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.loop.realtime import Realtime, RealtimeSettings
from reflexarc_runtime.loop.realtime.grant import require_all

ORDINARY = (os.SCHED_OTHER, 0)
LOOP, WATCHDOG, RECORDER, ENDED = 10, 11, 12, 13
SENSOR, SYNCER, STRAY = 20, 21, 22
EVERYTHING = RealtimeSettings(50, (1,), whole_machine=True, strict=True)


def refused(*_: object) -> None:
    raise OSError(errno.EPERM, "Operation not permitted")


@dataclass
class FakeKernel:
    refuses: frozenset[str] = frozenset()
    most_priority: int = 99
    present: frozenset[int] = frozenset({0, 1, 2, 3})
    unlimited: bool = True
    can_clear_reset: bool = True
    governs: str = "performance"
    threads_by_number: dict[int, str] = field(
        default_factory=lambda: {LOOP: "MainThread", WATCHDOG: "watchdog", RECORDER: "", ENDED: ""}
    )
    scheduled: dict[int, tuple[int, int]] = field(default_factory=dict)
    placed: dict[int, set[int]] = field(default_factory=dict)
    locked: str = ""
    held: int = 0

    def _ask(self, what: str) -> None:
        if what in self.refuses:
            refused()

    def set_timer_slack(self, slack_ns: int) -> None:
        self._ask("slack")

    def threads(self) -> dict[int, str]:
        return self.threads_by_number

    def this_thread(self) -> int:
        return LOOP

    def scheduling(self, thread: int) -> tuple[int, int]:
        if thread == ENDED:
            raise ProcessLookupError(errno.ESRCH, "No such process")
        return self.scheduled.get(thread, ORDINARY)

    def schedule(self, thread: int, scheduling: tuple[int, int]) -> None:
        self._ask("fifo")
        keeps_reset = scheduling[0] & os.SCHED_RESET_ON_FORK
        had_reset = self.scheduling(thread)[0] & os.SCHED_RESET_ON_FORK
        if scheduling[1] > self.most_priority or (
            had_reset and not keeps_reset and not self.can_clear_reset
        ):
            refused()
        self.scheduled[thread] = scheduling

    def processors(self, thread: int) -> set[int]:
        return self.placed.get(thread, {0, 1, 2, 3})

    def use_processors(self, thread: int, processors: set[int]) -> None:
        if not processors & self.present:
            raise OSError(errno.EINVAL, "Invalid argument")
        self.placed[thread] = processors & self.present

    def starts(self, new: int, by: int) -> None:
        """One thread starts another: what sched(7) says that it inherits."""
        policy, priority = self.scheduling(by)
        reset = policy & os.SCHED_RESET_ON_FORK
        self.scheduled[new] = ORDINARY if reset else (policy, priority)
        self.placed[new] = self.processors(by)
        self.threads_by_number[new] = ""

    def lock_memory(self, *, future: bool) -> None:
        self._ask("memory")
        self.locked = "future" if future else "so far"

    def unlock_memory(self) -> None:
        self.locked = ""

    def may_lock_without_limit(self) -> bool:
        return self.unlimited

    def hold_wake_latency(self) -> int:
        self._ask("latency")
        self.held += 1
        return 7

    def release(self, handle: int) -> None:
        self.held -= 1

    def governor(self) -> str:
        self._ask("governor")
        return self.governs


def test_all_is_obtained_as_asked_and_given_back():
    kernel = FakeKernel()
    with Realtime(EVERYTHING, kernel) as realtime:
        assert not [grant for grant in realtime.grants if grant.refusal]
        require_all(realtime.grants)
        assert kernel.scheduled == {
            LOOP: (os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, 50),
            WATCHDOG: (os.SCHED_FIFO, 51),
            RECORDER: (os.SCHED_FIFO, 1),
        }
        assert (kernel.placed, kernel.locked, kernel.held) == ({LOOP: {1}}, "future", 1)
    assert set(kernel.scheduled.values()) == {ORDINARY}
    assert (kernel.placed[LOOP], kernel.locked, kernel.held) == ({0, 1, 2, 3}, "", 0)


def test_without_a_flag_only_what_needs_no_right_is_asked():
    kernel = FakeKernel(refuses=frozenset({"fifo", "memory", "latency"}))
    with Realtime(RealtimeSettings(), kernel) as realtime:
        assert realtime.words == "timer slack 1 ns; collector frozen; turns of 0.1 ms"
    assert kernel.scheduled == {}


def test_a_thread_that_computes_gives_the_lock_away_soon_while_the_loop_runs():
    usual_s = sys.getswitchinterval()
    with Realtime(RealtimeSettings(), FakeKernel()):
        assert sys.getswitchinterval() == pytest.approx(0.0001)
    assert sys.getswitchinterval() == usual_s


@pytest.mark.parametrize(
    ("kernel", "words"),
    [
        (
            FakeKernel(refuses=frozenset({"fifo"})),
            "SCHED_FIFO 50 refused (operation not permitted)",
        ),
        (FakeKernel(refuses=frozenset({"memory"})), "memory locked refused"),
        (
            FakeKernel(most_priority=50),
            "SCHED_FIFO 50 refused, got SCHED_FIFO 49 (operation not permitted); "
            "watchdog 51 refused, got watchdog 50 (operation not permitted); other threads 1",
        ),
        (FakeKernel(unlimited=False), "memory locked refused, got what there is so far"),
        (FakeKernel(present=frozenset({0})), "processor 1 refused"),
    ],
)
def test_what_is_refused_is_said_and_strict_does_not_begin(kernel: FakeKernel, words: str):
    with Realtime(EVERYTHING, kernel) as realtime:
        assert words in realtime.words
        with pytest.raises(UsageError, match=r"--realtime strict: .*; or --realtime warn"):
            require_all(realtime.grants)


def test_a_machine_without_deep_sleep_or_governor_is_strict_enough():
    kernel = FakeKernel(refuses=frozenset({"latency", "governor"}))
    with Realtime(EVERYTHING, kernel) as realtime:
        require_all(realtime.grants)
        assert "no deep sleep of processors refused (operation not permitted)" in realtime.words
        assert "no governor here" in realtime.words
    with Realtime(EVERYTHING, FakeKernel(governs="powersave")) as realtime:
        require_all(realtime.grants)
        assert "governor performance refused (it is powersave)" in realtime.words


def test_processors_that_are_not_there_are_named():
    kernel = FakeKernel(present=frozenset({0, 1}))
    with Realtime(RealtimeSettings(processors=(1, 9)), kernel) as realtime:
        assert "processors 1, 9 refused, got 1 (the others are not there)" in realtime.words


def test_who_may_not_let_its_threads_inherit_again_still_becomes_ordinary():
    kernel = FakeKernel(can_clear_reset=False)
    with Realtime(RealtimeSettings(50), kernel):
        pass
    assert kernel.scheduled[LOOP] == (os.SCHED_OTHER | os.SCHED_RESET_ON_FORK, 0)


@pytest.mark.parametrize("asked", [1, 2, 3, 50, 98])
@pytest.mark.parametrize("most", [0, 1, 2, 3, 49, 50, 51, 97, 98, 99])
def test_the_watchdog_is_above_the_loop_whatever_is_granted(asked: int, most: int):
    kernel = FakeKernel(most_priority=most)
    with Realtime(RealtimeSettings(asked), kernel) as realtime:
        loop = kernel.scheduled.get(LOOP, ORDINARY)[1]
        watchdog = kernel.scheduled.get(WATCHDOG, ORDINARY)[1]
        assert loop == (asked if asked < most else asked - 1 if asked == most else 0)
        assert watchdog == (loop + 1 if loop else 0)
        assert kernel.scheduled.get(RECORDER, ORDINARY)[1] == min(1, loop)
        said = {grant.asked: grant.obtained for grant in realtime.grants}
    assert said[f"SCHED_FIFO {asked}"] == (f"SCHED_FIFO {loop}" if loop else "")
    assert said.get(f"watchdog {asked + 1}") == (f"watchdog {watchdog}" if loop else None)
    assert said.get("other threads 1") == ("other threads 1" if loop else None)


def test_a_right_that_is_too_small_for_the_watchdog_is_noticed_before_there_is_one():
    kernel = FakeKernel(most_priority=50, threads_by_number={LOOP: "MainThread"})
    with (
        Realtime(EVERYTHING, kernel) as realtime,
        pytest.raises(UsageError, match="ulimit -r 51"),
    ):
        require_all(realtime.grants)


@pytest.mark.parametrize("priority", [0, 50])
def test_who_begins_later_is_taken_in_and_has_what_was_usual_at_the_end(priority: int):
    kernel, all_of_them = FakeKernel(), {0, 1, 2, 3}
    with Realtime(RealtimeSettings(priority, (1,)), kernel) as realtime:
        kernel.starts(SENSOR, by=LOOP)
        realtime.take_in()
        kernel.starts(SYNCER, by=RECORDER)
        kernel.starts(STRAY, by=LOOP)  # too late, but not for ever
        behind = (os.SCHED_FIFO, 1) if priority else ORDINARY
        for later in (SENSOR, SYNCER):
            assert (kernel.scheduling(later), kernel.placed[later]) == (behind, all_of_them)
        assert (kernel.scheduling(STRAY), kernel.placed[STRAY]) == (ORDINARY, {1})
        assert all(not grant.refusal for grant in realtime.grants)
    for thread in (LOOP, WATCHDOG, RECORDER, SENSOR, SYNCER, STRAY):
        assert (kernel.scheduling(thread), kernel.processors(thread)) == (ORDINARY, all_of_them)


def test_who_begins_later_and_is_refused_is_said():
    kernel = FakeKernel()
    with Realtime(RealtimeSettings(50), kernel) as realtime:
        kernel.starts(SENSOR, by=LOOP)
        kernel.refuses = frozenset({"fifo"})
        realtime.take_in()
        assert "watchdog 51; other threads 1 refused (operation not" in realtime.words


def test_a_thread_that_chose_its_own_scheduling_keeps_it():
    kernel, own = FakeKernel(), (os.SCHED_BATCH, 0)
    kernel.scheduled[RECORDER] = own
    with Realtime(RealtimeSettings(50, (1,)), kernel):
        kernel.starts(SYNCER, by=RECORDER)
        kernel.scheduled[SYNCER], kernel.placed[RECORDER] = own, {3}
    assert (kernel.scheduling(SYNCER), kernel.scheduling(RECORDER)) == (own, own)
    assert kernel.placed[RECORDER] == {3}


def test_without_a_flag_no_thread_is_looked_at():
    class Blind(FakeKernel):
        def threads(self) -> dict[int, str]:
            raise AssertionError

    with Realtime(RealtimeSettings(), Blind()) as realtime:
        realtime.take_in()


def test_the_kernel_of_this_machine_answers():
    with Realtime(EVERYTHING) as realtime:
        assert all(grant.obtained or grant.refusal for grant in realtime.grants)
