"""One thread for the room's tests: they run beside others, and the bits are the same on any."""

from collections.abc import Iterator

import pytest

from reflexarc_sim_bridge.native import threads


@pytest.fixture(autouse=True, scope="session")
def _one_thread() -> Iterator[None]:
    before = threads.thread_count()
    threads.set_thread_count(1)
    yield
    threads.set_thread_count(before)
