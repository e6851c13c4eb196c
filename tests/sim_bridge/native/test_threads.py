"""Work that is shared out among threads."""

import threading
from collections.abc import Iterator

import pytest

from reflexarc_sim_bridge.native.threads import set_thread_count, shared, thread_count, together


@pytest.fixture(params=[1, 2, 5])
def threads(request: pytest.FixtureRequest) -> Iterator[int]:
    before = thread_count()
    set_thread_count(request.param)
    yield request.param
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
