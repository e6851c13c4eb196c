"""A barrier: no thread continues before all have arrived."""

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt
import pytest

from reflexarc_sim_bridge.native.decorators import fused_free
from reflexarc_sim_bridge.native.threads import set_thread_count, thread_count, together
from reflexarc_trainer.sarsa.batched.barrier import Barrier, new_barrier, wait_for_all

ROUNDS = 20_000


@fused_free
def march(
    barrier: Barrier, steps: npt.NDArray[np.int64], mine: int, threads: int, rounds: int
) -> int:
    """Take a step, wait for all, and count the threads that are seen at another step."""
    astray = 0
    for k in range(rounds):
        steps[mine] = k
        wait_for_all(barrier, threads)
        for other in range(threads):
            astray += steps[other] != k
        wait_for_all(barrier, threads)  # no thread takes the next step while another still compares
    return astray


@pytest.fixture
def three_threads() -> Iterator[None]:
    before = thread_count()
    set_thread_count(3)
    yield
    set_thread_count(before)


@pytest.mark.usefixtures("three_threads")
def test_what_each_thread_wrote_before_the_barrier_is_seen_by_all_behind_it() -> None:
    barrier, steps, astray = new_barrier(), np.full(3, -1), np.full(3, -1)

    def walk(first: int, end: int) -> None:
        assert end == first + 1, "one part a thread"
        astray[first] = march(barrier, steps, first, 3, ROUNDS)

    together(walk, 3)
    np.testing.assert_array_equal(astray, 0)
    np.testing.assert_array_equal(steps, ROUNDS - 1)


def test_one_thread_passes_alone() -> None:
    assert march(new_barrier(), np.zeros(1, np.int64), 0, 1, 10) == 0
