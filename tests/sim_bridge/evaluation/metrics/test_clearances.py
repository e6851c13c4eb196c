import math

import numpy as np
import pytest

from reflexarc_sim_bridge.evaluation.metrics.clearances import BINS, percentile
from support.hand_tracks import figures, marks, track_of


def test_share_of_the_time_below_half_of_r() -> None:
    clearance_m = np.where(np.arange(100) < 30, 0.2, 1.0)  # 0.4 R and 2 R
    found = figures(track_of(100, clearance_m=clearance_m))
    assert found["close"] == pytest.approx(0.3)
    assert found["least_clearance"] == pytest.approx(0.4)


def test_an_agent_that_met_something_has_no_clearance_left() -> None:
    met = np.zeros((50, 2), np.bool_)
    met[20, 1] = True
    found = figures(track_of(50, 2, met=met, clearance_m=0.5))
    assert found["least_clearance"] == pytest.approx(0.5)  # mean of 1 R and 0


def test_a_twentieth_of_an_even_spread_lies_below_a_twentieth_of_it() -> None:
    found = figures(track_of(10_000, clearance_m=np.linspace(0.0, 1.0, 10_000)))  # 0 to 2 R
    assert found["clearance_p5"] == pytest.approx(0.1, abs=0.002)


@pytest.mark.parametrize("share", [0.02, 0.05, 0.3, 0.5, 0.95])
def test_percentiles_agree_with_those_of_all_values_within_a_bin(share: float) -> None:
    values = np.random.default_rng(4).gamma(2.0, 0.3, 20_000)
    counts, edges = np.histogram(values, bins=BINS, range=(0.0, 3.0))
    expected = float(np.quantile(values[values < edges[-1]], share))
    assert percentile(counts.astype(float), share) == pytest.approx(expected, abs=0.01)


def test_of_nothing_there_is_no_percentile() -> None:
    assert math.isnan(percentile(np.zeros(BINS), 0.05))


def test_all_the_time_is_in_the_histogram_however_far_away() -> None:
    found = figures(track_of(10, clearance_m=5.0), track_of(10, met=marks(10, 3), clearance_m=0.0))
    assert found["close"] == pytest.approx(0.5)
