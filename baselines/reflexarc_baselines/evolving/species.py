"""What can be evolved, and how each kind of genome breeds and decides."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Protocol

import numpy as np

from reflexarc_baselines.evolving.genetics import Costs, Genomes
from reflexarc_baselines.evolving.motion_species import closed_loop, viewing_directions
from reflexarc_baselines.evolving.spiking_species import SpikingSpecies
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.policy.policy import RememberingPolicy


class Species(Protocol):
    """A baseline that evolves."""

    @property
    def contract(self) -> PolicyContract:
        """What its bodies see, do and remember."""
        ...

    @property
    def home_world(self) -> str:
        """Where it evolves."""
        ...

    def first(self, count: int, generator: np.random.Generator) -> Genomes:
        """The first generation."""
        ...

    def children(self, genomes: Genomes, costs: Costs, generator: np.random.Generator) -> Genomes:
        """The next generation, by what this one cost."""
        ...

    def crowd(self, genomes: Genomes) -> RememberingPolicy:
        """Decides for all agents, divided evenly among the genomes, in order."""
        ...

    def grown(self, genes: Genomes) -> object:
        """What one genome, (genes,), means: the dataclass that is written to a file."""
        ...


SPECIES: Mapping[str, Species] = MappingProxyType(
    {
        "closed-loop": closed_loop(),
        "evolved-viewing": viewing_directions(),
        "spiking-network": SpikingSpecies(),
    }
)
"""By the names of the baselines."""


def species_named(name: str) -> Species:
    """The species of a baseline.

    Raises:
        UsageError: no baseline of this name evolves.
    """
    if name not in SPECIES:
        raise UsageError(f"evolving: none is named {name!r}; known: {', '.join(SPECIES)}")
    return SPECIES[name]
