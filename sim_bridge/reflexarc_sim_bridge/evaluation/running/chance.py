"""The same chance for all: the global generators begin alike before each piece of work.

A contender that draws from Python's or NumPy's global generator would otherwise do something else
on another number of processes.
"""

import random
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

_SEED = 20_250_104


@contextmanager
def same_chance() -> Iterator[None]:
    """Within the context the global generators begin from one seed; afterwards they are as before.

    A generator that a contender keeps is its own affair.
    """
    before, before_numpy = random.getstate(), np.random.get_state()  # noqa: NPY002  # the global one
    random.seed(_SEED)
    np.random.seed(_SEED)  # noqa: NPY002  # a contender may draw from it
    try:
        yield
    finally:
        random.setstate(before)
        np.random.set_state(before_numpy)  # noqa: NPY002  # see above
