"""One thread for the room's tests: they run beside others, and the bits are the same on any."""

from collections.abc import Iterator

import numba
import pytest


@pytest.fixture(autouse=True, scope="session")
def _one_thread() -> Iterator[None]:
    before = numba.get_num_threads()
    numba.set_num_threads(1)
    yield
    numba.set_num_threads(before)
