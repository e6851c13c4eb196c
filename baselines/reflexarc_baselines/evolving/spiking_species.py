"""Genomes of the spiking network: 290 bits, bred as their source did.

The best quarter has four children each; of neighbouring pairs one in ten is crossed at a point;
bits flip; the best lives on as it is. The source flips 5 % of the bits, 14 of them in each child,
so that only the best is stable; 1 % is used here.
"""

from dataclasses import dataclass

import numpy as np

from reflexarc_baselines.baseline import Floats
from reflexarc_baselines.evolving.genetics import (
    Costs,
    Genomes,
    best,
    crossed_at_a_point,
    flipped,
    truncated,
)
from reflexarc_baselines.history.spiking_network import (
    BITS,
    NEURONS,
    Connections,
    contract_of_network,
    remembering,
    wires,
    wish,
)
from reflexarc_baselines.steering import steer
from reflexarc_runtime.arrays import Actions, Memories, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract

_CHILDREN, _CROSSED = 4, 0.1
_PERIOD_S = 0.1


@dataclass(frozen=True)
class SpikingSpecies:
    """Networks of ten spiking neurons."""

    flipped: float = 0.01
    """Share of the bits that mutate."""
    home_world: str = "reference-1"

    @property
    def contract(self) -> PolicyContract:
        """See `Species`."""
        return contract_of_network()

    def first(self, count: int, generator: np.random.Generator) -> Genomes:
        """Bits drawn evenly."""
        return generator.integers(0, 2, (count, NEURONS * BITS)).astype(np.float64)

    def children(self, genomes: Genomes, costs: Costs, generator: np.random.Generator) -> Genomes:
        """See the module."""
        parents = genomes[truncated(costs, len(genomes) // _CHILDREN)]
        born = flipped(crossed_at_a_point(parents, _CROSSED, generator), self.flipped, generator)
        born[0] = genomes[best(costs, 1)[0]]
        return born

    def crowd(self, genomes: Genomes) -> "SpikingCrowd":
        """See `Species`."""
        return SpikingCrowd(wires([self.grown(genes) for genes in genomes]))

    def grown(self, genes: Genomes) -> Connections:
        """See `Species`."""
        return Connections(tuple(map(_row, genes.reshape(NEURONS, BITS))))


@dataclass(frozen=True)
class SpikingCrowd:
    """Agents of many genomes, decided in one call."""

    wires: Floats

    def decide(self, retinas: RetinaBatch, memories: Memories) -> tuple[QValues, Actions, Memories]:
        """See `RememberingPolicy`."""
        turn, following = wish(self.wires, retinas, memories, _PERIOD_S)
        q_values, actions = steer(turn)
        return q_values, actions, remembering(following, actions)


def _row(bits: Genomes) -> str:
    text = "".join(str(int(bit)) for bit in bits)
    sign = "+" if text[0] == "1" else "-"
    return f"{sign} {text[1 : 1 + NEURONS]} {text[1 + NEURONS :]}"
