"""Global generators begin alike, and are put back."""

import random

import numpy as np

from reflexarc_sim_bridge.evaluation.running.chance import same_chance


def draws() -> tuple[float, float]:
    return random.random(), float(np.random.random())  # noqa: NPY002  # the global one


def test_chance_is_the_same_within_and_undisturbed_without() -> None:
    before = random.getstate()
    with same_chance():
        first = draws()
    with same_chance():
        assert draws() == first
    assert random.getstate() == before
    assert draws() != first
