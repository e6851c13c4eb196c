"""Genomes of motion detectors: reals between 0 and 1, each a place in the span of a number.

They breed by tournaments of three, even crossover and normal mutation; the best four live on as
they are. Never steering is a strong local optimum, so the first generation has small dead bands.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from reflexarc_baselines.baseline import Span
from reflexarc_baselines.evolving.genetics import (
    Costs,
    Genomes,
    best,
    crossed_evenly,
    mutated,
    tournaments,
)
from reflexarc_baselines.history.closed_loop import BEARINGS_RAD, SEPARATIONS_RAD
from reflexarc_baselines.history.motion_steering import Detectors, Wiring, wired, wish
from reflexarc_baselines.history.viewing_directions import FLOW_EYE, PERIOD_S, with_memory
from reflexarc_baselines.rays import brightness
from reflexarc_runtime.arrays import Actions, Memories, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec

_ELITE, _TOURNAMENT, _CROSSED, _MUTATED, _DEVIATION = 4, 3, 0.5, 0.25, 0.12
_FIRST_DEAD_BANDS = 0.3
"""Share of their span."""

_WEIGHT = Span(-1.0, 1.0)
_SHARED = (
    Span(0.05, 2.0, is_log=True),  # τ
    Span(0.2, 20.0, is_log=True),  # the slow mean's time constant
    Span(1e-3, 1.0, is_log=True),  # dead band
    Span(1e-4, 1.0, is_log=True),  # saturation
)
_DEAD_BAND = -2
"""Which gene."""


@dataclass(frozen=True)
class MotionSpecies:
    """Mirror pairs of motion detectors."""

    spans: tuple[Span, ...]
    """Of each gene."""
    detectors: Callable[[list[float]], Detectors]
    """From the numbers of a genome."""
    eye: RetinaSpec = FLOW_EYE
    home_world: str = "reference-1"

    @property
    def contract(self) -> PolicyContract:
        """See `Species`."""
        return with_memory(self.eye)

    def first(self, count: int, generator: np.random.Generator) -> Genomes:
        """Drawn evenly, but for the dead bands."""
        genomes = generator.random((count, len(self.spans)))
        genomes[:, _DEAD_BAND] *= _FIRST_DEAD_BANDS
        return genomes

    def children(self, genomes: Genomes, costs: Costs, generator: np.random.Generator) -> Genomes:
        """See the module."""
        count = len(genomes) - _ELITE
        mothers, fathers = (
            genomes[tournaments(costs, count, _TOURNAMENT, generator)] for _ in range(2)
        )
        born = crossed_evenly(mothers, fathers, _CROSSED, generator)
        changed = mutated(born, _MUTATED, _DEVIATION, generator)
        return np.concatenate([genomes[best(costs, _ELITE)], changed])

    def crowd(self, genomes: Genomes) -> "MotionCrowd":
        """See `Species`."""
        return MotionCrowd(wired([self.grown(genes) for genes in genomes], self.eye, PERIOD_S))

    def grown(self, genes: Genomes) -> Detectors:
        """See `Species`."""
        pairs = zip(self.spans, genes.tolist(), strict=True)
        return self.detectors([_within(span, share) for span, share in pairs])


@dataclass(frozen=True)
class MotionCrowd:
    """Agents of many genomes, decided in one call."""

    wiring: Wiring

    def decide(self, retinas: RetinaBatch, memories: Memories) -> tuple[QValues, Actions, Memories]:
        """See `RememberingPolicy`."""
        genomes = len(self.wiring.weights)
        rays = brightness(retinas)
        turn, following = wish(
            self.wiring,
            rays.reshape(genomes, -1, rays.shape[-1]),
            memories.reshape(genomes, -1, memories.shape[-1]),
        )
        band = np.broadcast_to(self.wiring.dead_band, turn.shape)
        q_values = np.stack([band, turn, -turn], axis=-1).reshape(-1, 3)
        return q_values, q_values.argmax(axis=1), following.reshape(memories.shape)


def viewing_directions() -> MotionSpecies:
    """Four pairs that look anywhere ahead and to the sides: 16 genes."""
    apart = Span(FLOW_EYE.fov_rad / FLOW_EYE.rays, math.radians(60.0))
    bearing = Span(0.0, math.radians(80.0))

    def detectors(numbers: list[float]) -> Detectors:
        bearings, separations, weights = (tuple(numbers[k : k + 4]) for k in (0, 4, 8))
        return Detectors(bearings, separations, weights, *numbers[12:])

    return MotionSpecies((bearing,) * 4 + (apart,) * 4 + (_WEIGHT,) * 4 + _SHARED, detectors)


def closed_loop() -> MotionSpecies:
    """Two pairs at ±45°: their weights, and what they share; 6 genes."""

    def detectors(numbers: list[float]) -> Detectors:
        return Detectors(BEARINGS_RAD, SEPARATIONS_RAD, (numbers[0], numbers[1]), *numbers[2:])

    return MotionSpecies((_WEIGHT,) * 2 + _SHARED, detectors)


def _within(span: Span, share: float) -> float:
    """The number at a share of a span."""
    if span.is_log:
        return math.exp(math.log(span.low) + share * math.log(span.high / span.low))
    return span.low + share * (span.high - span.low)
