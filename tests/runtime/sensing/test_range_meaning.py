"""What a driver's numbers mean: a limit of its own that is wrong hides nothing."""

import math

import numpy as np
import pytest

from reflexarc_runtime.sensing.range_meaning import RangeMeaning
from reflexarc_runtime.sensing.scan import UnusableScanError


def test_a_constant_beyond_the_limit_is_nothing_and_measurements_beyond_it_are_what_they_are():
    constant = np.array([1.0, 65.533, 65.533, 65.5331])
    assert RangeMeaning().read(constant, 0.1, 12.0).tolist() == [1.0, math.inf, math.inf, math.inf]
    wall = np.array([0.61, 0.6, 0.62, math.inf])
    assert RangeMeaning().read(wall, 0.1, 0.5).tolist() == [0.61, 0.6, 0.62, math.inf]


def test_a_limit_that_the_user_gave_is_believed_or_contradicted_by_name():
    assert RangeMeaning(max_m=12.0).read(np.array([11.0, 12.0])).tolist() == [11.0, math.inf]
    with pytest.raises(UnusableScanError, match=r"--range-max 0\.5"):
        RangeMeaning(max_m=0.5).read(np.array([0.6, 0.61]))


@pytest.mark.parametrize("word", ["", "None", "-1", "inf", "zero "])
def test_what_stands_for_nothing_must_be_a_word_or_a_distance(word: str):
    with pytest.raises(Exception, match="--no-return"):
        RangeMeaning((word,))
