"""Selection, crossover and mutation, as pure functions of a random generator.

A population is an array (genomes, genes): reals in [0, 1], or bits. Costs are (genomes,), the
smallest the best.
"""

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Genomes: TypeAlias = npt.NDArray[np.float64]
"""(genomes, genes); bits are 0.0 and 1.0."""
Costs: TypeAlias = npt.NDArray[np.float64]
"""(genomes,)"""
Places: TypeAlias = npt.NDArray[np.int64]
"""Which genomes of a population: (n,)."""


def best(costs: Costs, count: int) -> Places:
    """The best genomes, the best first; of equals the former."""
    return np.argsort(costs, kind="stable")[:count]


def truncated(costs: Costs, parents: int) -> Places:
    """As many parents as genomes: each of the best equally often, the copies side by side."""
    return np.repeat(best(costs, parents), len(costs) // parents)


def tournaments(costs: Costs, count: int, size: int, generator: np.random.Generator) -> Places:
    """Winners of so many tournaments among genomes drawn with replacement."""
    drawn = generator.integers(0, len(costs), (count, size))
    winners: Places = drawn[np.arange(count), costs[drawn].argmin(axis=1)]
    return winners


def crossed_evenly(
    mothers: Genomes, fathers: Genomes, share: float, generator: np.random.Generator
) -> Genomes:
    """Children of whom a share has each gene from either parent; the rest are their mothers."""
    is_crossed = generator.random((len(mothers), 1)) < share
    from_father = generator.random(mothers.shape) < 0.5
    return np.where(is_crossed & from_father, fathers, mothers)


def crossed_at_a_point(genomes: Genomes, share: float, generator: np.random.Generator) -> Genomes:
    """Neighbouring pairs, of which a share swap all genes behind a point of their own."""
    even, odd = genomes[0::2], genomes[1::2]
    points = generator.integers(1, genomes.shape[1], (len(even), 1))
    is_crossed = generator.random((len(even), 1)) < share
    swapped = is_crossed & (np.arange(genomes.shape[1]) >= points)
    children = np.empty_like(genomes)
    children[0::2], children[1::2] = np.where(swapped, odd, even), np.where(swapped, even, odd)
    return children


def mutated(
    genomes: Genomes, share: float, deviation: float, generator: np.random.Generator
) -> Genomes:
    """Reals of which a share is moved by a normal deviate, thrown back at 0 and 1."""
    moves = generator.normal(0.0, deviation, genomes.shape)
    moved = genomes + np.where(generator.random(genomes.shape) < share, moves, 0.0)
    return 1.0 - np.abs(1.0 - np.abs(moved) % 2.0)


def flipped(bits: Genomes, share: float, generator: np.random.Generator) -> Genomes:
    """Bits of which a share is flipped."""
    return np.where(generator.random(bits.shape) < share, 1.0 - bits, bits)
