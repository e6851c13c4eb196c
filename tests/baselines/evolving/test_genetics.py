import numpy as np
import pytest

from reflexarc_baselines.evolving.genetics import (
    best,
    crossed_at_a_point,
    crossed_evenly,
    flipped,
    mutated,
    tournaments,
    truncated,
)

COSTS = np.array([3.0, 1.0, 4.0, 1.0, 5.0, 9.0, 2.0, 6.0])


def generator() -> np.random.Generator:
    return np.random.default_rng(11)


def test_the_best_come_first_and_of_equals_the_former() -> None:
    assert best(COSTS, 4).tolist() == [1, 3, 6, 0]


def test_truncation_gives_each_parent_as_many_children() -> None:
    assert truncated(COSTS, 2).tolist() == [1, 1, 1, 1, 3, 3, 3, 3]


def test_the_best_wins_a_tournament_as_often_as_it_is_drawn() -> None:
    """Of 8 genomes, in tournaments of 3: 1 − (7/8)³."""
    costs = np.arange(8.0)
    won = tournaments(costs, 20_000, 3, generator())
    assert (won == 0).mean() == pytest.approx(1.0 - (7 / 8) ** 3, abs=0.01)
    assert (won == 7).mean() == pytest.approx((1 / 8) ** 3, abs=0.002)


def test_crossing_at_a_point_keeps_each_gene_in_its_pair() -> None:
    genomes = np.arange(60.0).reshape(6, 10)
    crossed = crossed_at_a_point(genomes, 1.0, generator())
    for pair in range(3):
        mother, child = genomes[2 * pair], crossed[2 * pair]
        swaps = np.diff((child != mother).astype(int))
        assert swaps.tolist().count(1) == 1
        assert swaps.min() == 0
        both = crossed[2 * pair] + crossed[2 * pair + 1]
        assert (both == genomes[2 * pair] + genomes[2 * pair + 1]).all()
    assert (crossed_at_a_point(genomes, 0.0, generator()) == genomes).all()


def test_even_crossing_takes_half_of_the_genes_of_a_share_of_the_children() -> None:
    mothers, fathers = np.zeros((2000, 16)), np.ones((2000, 16))
    children = crossed_evenly(mothers, fathers, 0.5, generator())
    is_crossed = children.any(axis=1)
    assert is_crossed.mean() == pytest.approx(0.5, abs=0.03)
    assert children[is_crossed].mean() == pytest.approx(0.5, abs=0.02)


def test_mutation_moves_a_share_and_stays_within_bounds() -> None:
    genomes = np.full((500, 40), 0.95)
    moved = mutated(genomes, 0.25, 0.12, generator())
    assert (np.abs(moved - genomes) > 1e-9).mean() == pytest.approx(0.25, abs=0.02)
    assert 0.0 <= moved.min() < 0.6
    assert 0.95 < moved.max() <= 1.0


def test_a_mutation_over_the_edge_is_thrown_back() -> None:
    """In the mean over many deviates, |x| of x = N(0, σ) has the mean σ √(2/π)."""
    moved = mutated(np.zeros((1000, 40)), 1.0, 0.12, generator())
    assert moved.mean() == pytest.approx(0.12 * np.sqrt(2.0 / np.pi), rel=0.02)


def test_a_share_of_the_bits_flips() -> None:
    bits = generator().integers(0, 2, (200, 290)).astype(float)
    changed = flipped(bits, 0.05, generator())
    assert set(np.unique(changed)) == {0.0, 1.0}
    assert (changed != bits).mean() == pytest.approx(0.05, abs=0.005)
