"""Work that is shared out among threads."""

import threading
import time
from collections.abc import Iterator
from concurrent.futures import Future

import pytest

from reflexarc_sim_bridge.native.threads import (
    FEWEST_AGENTS,
    set_thread_count,
    shared,
    thread_count,
    together,
)


@pytest.fixture(params=[1, 2, 5])
def threads(request: pytest.FixtureRequest) -> Iterator[int]:
    before = thread_count()
    set_thread_count(request.param)
    yield request.param
    set_thread_count(before)


@pytest.fixture
def two_threads() -> Iterator[None]:
    before = thread_count()
    set_thread_count(2)
    yield
    set_thread_count(before)


@pytest.mark.parametrize("share", [shared, together])
@pytest.mark.parametrize("parts", [1, 2, 7, 1000])
def test_every_part_is_done_once(share: object, parts: int, threads: int) -> None:
    done = [0] * parts

    def work(first: int, end: int) -> None:
        for k in range(first, end):
            done[k] += 1

    assert callable(share)
    share(work, parts)
    assert done == [1] * parts


def test_parts_that_wait_for_each_other_all_run_at_once(threads: int) -> None:
    barrier = threading.Barrier(threads, timeout=10.0)
    together(lambda first, end: barrier.wait(), threads)
    assert not barrier.broken


def test_groups_that_are_called_at_once_do_not_wait_for_each_other(threads: int) -> None:
    """Two groups of parts that wait must not each take half of the threads."""
    barriers = [threading.Barrier(threads, timeout=10.0) for _ in range(2)]
    callers = [
        threading.Thread(target=together, args=(lambda f, e, b=b: b.wait(), threads))
        for b in barriers
    ]
    for caller in callers:
        caller.start()
    for caller in callers:
        caller.join(timeout=20.0)
    assert not any(caller.is_alive() for caller in callers)
    assert not any(barrier.broken for barrier in barriers)


def test_what_a_part_raises_reaches_the_caller(threads: int) -> None:
    def work(first: int, end: int) -> None:
        if end == threads:
            raise ZeroDivisionError("the last one")

    with pytest.raises(ZeroDivisionError, match="the last one"):
        together(work, threads)


def test_work_that_raises_is_waited_for_by_whoever_shared_it(two_threads: None) -> None:
    """Nobody may still write to the agents' rows when the caller goes on."""
    done: list[str] = []

    def work(first: int, _: int) -> None:
        if first == 0:
            raise ZeroDivisionError("the caller's part")
        time.sleep(0.2)
        done.append("the other part")

    with pytest.raises(ZeroDivisionError, match="the caller's part"):
        shared(work, 2 * FEWEST_AGENTS)
    assert done == ["the other part"]


def test_what_a_part_raises_counts_more_than_an_interrupt(
    two_threads: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A policy from a world with holes must not be saved because somebody pressed Ctrl-C."""
    result = Future.result

    def interrupted(call: "Future[object]", timeout: float | None = None) -> object:
        if threading.current_thread() is threading.main_thread():
            raise KeyboardInterrupt
        return result(call, timeout)

    def work(first: int, _: int) -> None:
        time.sleep(0.1)
        raise ZeroDivisionError("a hole")

    monkeypatch.setattr(Future, "result", interrupted)
    with pytest.raises(ZeroDivisionError, match="a hole"):
        together(work, 2)
