"""Clocks that are made to drift and to step, seen through ways that vary and stall."""

import numpy as np
import pytest

from reflexarc_logs.checking import delay_course
from reflexarc_logs.checking.delay_course import DelayCourse

MS = 1_000_000
S = 1_000 * MS


def course(
    seconds: int, *, drift: float = 0.0, step_ns: int = 0, at_s: int = 0, stalls: int = 0
) -> DelayCourse:
    """50 messages a second, 1 to 11 ms on their way; a stall holds all up for 1.5 s."""
    rng = np.random.default_rng(4)
    sent_ns = np.arange(50 * seconds) * 20 * MS
    log_ns = sent_ns + MS + (rng.exponential(2.0, len(sent_ns)).clip(0, 10) * MS).astype(int)
    for number in range(stalls):
        begin = (5 + 7 * number) * S
        held = (log_ns > begin) & (log_ns < begin + 3 * S // 2)
        log_ns[held] = begin + 3 * S // 2
    log_ns = np.maximum.accumulate(log_ns)
    stamps = sent_ns + (drift * sent_ns).astype(int) + step_ns * (sent_ns >= at_s * S)
    found = DelayCourse()
    for logged, stamp in zip(log_ns.tolist(), stamps.tolist(), strict=True):
        found.add(logged + 1_700_000_000 * S, stamp)
    return found


@pytest.mark.parametrize("drift", [-500e-6, 0.0, 300e-6, 0.05])
def test_a_drift_is_found_whatever_the_way_is_like(drift: float) -> None:
    assert course(60, drift=drift, stalls=4).drift() == pytest.approx(drift, abs=40e-6)


def test_a_network_that_stalls_is_no_step() -> None:
    assert course(60, stalls=6).steps() == []


@pytest.mark.parametrize("step_ns", [-3600 * S, -50 * MS, 40 * MS, 7 * S])
def test_a_step_is_found_with_its_size_and_its_time(step_ns: int) -> None:
    found = course(60, step_ns=step_ns, at_s=31)
    steps = found.steps()
    assert sum(step.step_ns for step in steps) / len(steps) == pytest.approx(step_ns, abs=8 * MS)
    assert abs(steps[0].at_ns - (1_700_000_000 + 31) * S) <= 4 * S
    assert found.drift() == pytest.approx(0.0, abs=40e-6)


@pytest.mark.parametrize("at_s", [2, 3, 4])
def test_a_step_is_found_in_a_log_of_six_seconds(at_s: int) -> None:
    [step] = course(6, step_ns=-300 * MS, at_s=at_s).steps()
    assert step.step_ns == pytest.approx(-300 * MS, abs=20 * MS)
    assert course(6).steps() == []


def test_a_short_log_says_nothing_of_drift() -> None:
    assert course(3, drift=0.05).drift() is None


def test_memory_does_not_grow_with_the_log(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(delay_course, "MOST_WINDOWS", 32)
    found = course(300, drift=300e-6, step_ns=5 * S, at_s=120, stalls=20)
    assert len(found._windows) <= 33
    assert found.drift() == pytest.approx(300e-6, abs=40e-6)
    assert [step.step_ns for step in found.steps()] == [pytest.approx(5 * S, abs=30 * MS)]


def test_a_backlog_that_drains_slowly_is_no_step() -> None:
    found = DelayCourse()
    for k in range(50 * 60):
        drained = max(0.0, 1.0 - abs(k / 50 - 30.0) / 1.2)  # up and down within 2.4 s
        found.add(k * 20 * MS + int(drained * 800 * MS), k * 20 * MS)
    assert found.steps() == []
