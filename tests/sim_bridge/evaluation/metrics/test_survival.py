import math

import numpy as np
import pytest

from reflexarc_sim_bridge.evaluation.metrics.survival import (
    BIN,
    BINS,
    restricted_mean,
    survival_curve,
    way_lives,
)
from reflexarc_sim_bridge.evaluation.metrics.track import Floats
from support.hand_tracks import figures, marks, track_of


def kaplan_meier(lengths: Floats, ended: Floats, at: Floats) -> Floats:
    """The estimator itself, life by life: the product of 1 − 1/n over all ends up to there."""
    order = np.argsort(lengths, kind="stable")
    left, survives, steps = len(lengths), 1.0, [(0.0, 1.0)]
    for k in order:
        if ended[k]:
            survives *= 1.0 - 1.0 / left
        left -= 1
        steps.append((float(lengths[k]), survives))
    times, values = np.array(steps).T
    return values[np.searchsorted(times, at, side="right") - 1]


def test_without_a_collision_everybody_goes_on() -> None:
    found = figures(track_of(300))  # 30 m: 15 mean free paths
    assert found["free_way"] == pytest.approx(BIN * BINS)
    assert found["free_time"] == pytest.approx(BIN * BINS)


def test_one_life_by_hand() -> None:
    # Every 3 m, 1.5 mean free paths, a collision; the seventh bin (1.5 to 1.75) ends each life.
    met = marks(300, *range(29, 300, 30))
    lives = way_lives(track_of(300, met=met)).sum(axis=0)
    curve = survival_curve(lives)
    assert curve[:7].tolist() == [1.0] * 7
    assert curve[7] == 0.0
    assert restricted_mean(lives) == pytest.approx(1.5 + BIN / 2)
    assert lives[1].sum() == 10.0


def test_exponential_lives_have_their_own_curve() -> None:
    """Collisions at random, one a mean free path: S = exp(−ℓ), area 1 − e⁻¹⁰."""
    met = np.random.default_rng(1).random((4000, 100)) < 0.05  # steps of 1/20 mean free path
    track = track_of(4000, 100, met=met)
    lives = way_lives(track).sum(axis=0)
    # A life of five steps ends on a border, and so in the bin behind it.
    decay = np.append(1.0, 0.95 ** (5.0 * np.arange(1, 25) - 1.0))
    assert np.abs(survival_curve(lives)[:25] - decay).max() < 0.01
    assert restricted_mean(lives) == pytest.approx(1.0 - math.exp(-10.0), abs=0.05)


def test_cut_lives_are_counted_as_kaplan_and_meier_do() -> None:
    generator = np.random.default_rng(2)
    found, lengths, ended = np.zeros((2, BINS + 1)), [], []
    for _ in range(1500):
        steps = int(generator.integers(1, 160))
        meets = generator.random() < 0.5
        met = marks(steps, steps - 1) if meets else marks(steps)
        found += way_lives(track_of(steps, met=met)).sum(axis=0)
        lengths.append(steps / 20.0)
        ended.append(float(meets))
    at = BIN * np.arange(28)
    # A life that ends on a border belongs to the bin behind it.
    exact = kaplan_meier(np.array(lengths), np.array(ended), np.maximum(at - 1e-9, 0.0))
    assert np.abs(survival_curve(found)[:28] - exact).max() < 0.002


def test_nobody_has_no_curve() -> None:
    assert math.isnan(restricted_mean(np.zeros((2, BINS + 1))))


def test_behind_the_last_life_the_curve_is_unknown_and_taken_to_stay() -> None:
    lives = way_lives(track_of(40)).sum(axis=0)  # 2 mean free paths
    curve = survival_curve(lives)
    assert curve[8] == 1.0
    assert np.isnan(curve[-1])
    assert restricted_mean(lives) == pytest.approx(BIN * BINS)
