"""What is made worse about a world, to see how soon a policy breaks: its senses, delay, and grip.

What the world has of it already stays: noises add as independent ones do, delays one after another.
"""

import math
from dataclasses import dataclass, replace

from reflexarc_runtime.config.checks import require
from reflexarc_runtime.errors import WorldError
from reflexarc_sim_bridge.worlds.world import World, WorldSource


@dataclass(frozen=True)
class Perturbation:
    """How much worse. By default nothing."""

    noise: float = 0.0
    """Standard deviation added to every value of a retina, as a share of full scale."""
    dropout: float = 0.0
    """Probability that a ray reads 0."""
    latency_s: float = 0.0
    """A retina is so old when the agent sees it."""
    slip: float = 0.0
    """Standard deviation of every speed, as a share of it, over the world's own time of slip."""

    def __post_init__(self) -> None:
        for name in ("noise", "dropout", "slip"):
            require(0.0 <= getattr(self, name) <= 1.0, name, "0 to 1", getattr(self, name))
        require(0.0 <= self.latency_s <= 1.0, "latency_s", "0 to 1 s", self.latency_s)


def perturbed(source: WorldSource, by: Perturbation) -> World:
    """The world, made worse.

    Raises:
        WorldError: a family of worlds; or more of it than a world may have.
    """
    if not isinstance(source, World):
        raise WorldError(f"{source.name}: expected one world to make worse, got a family")
    senses, chassis = source.senses, source.chassis
    return replace(
        source,
        senses=replace(
            senses,
            noise=math.hypot(senses.noise, by.noise),
            dropout=senses.dropout + (1.0 - senses.dropout) * by.dropout,
            latency_s=senses.latency_s + by.latency_s,
        ),
        chassis=replace(chassis, slip=math.hypot(chassis.slip, by.slip)),
    )
