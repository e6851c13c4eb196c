"""Evolved viewing directions: evolution chose where the motion detectors of an agent look.

Source: S. A. Huber, H. A. Mallot and H. H. Bülthoff, *Evolution of the sensorimotor control in an
autonomous agent*, From Animals to Animats 4, 1996. Its successors' abstracts could be read, its
numbers not, so the genome is reconstructed: four mirror pairs of correlation detectors, each with
a bearing, a separation and a weight, and four numbers that all share (`motion_steering.py`). At
uniform speed only the difference of the motors' weights matters. Evolved here by
`python -m reflexarc_baselines.evolving evolved-viewing`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import ClassVar

import numpy as np

from reflexarc_baselines.baseline import Fidelity, Origin, Span
from reflexarc_baselines.genome_files import shipped
from reflexarc_baselines.history.motion_steering import Detectors, Wiring, memory_of, wired, wish
from reflexarc_baselines.rays import brightness
from reflexarc_baselines.steering import steer
from reflexarc_runtime.arrays import Actions, Memories, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec, Shading
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract, reference_retina

FLOW_EYE = replace(reference_retina(), rays=32, samples=4, shading=Shading.COLOUR)
"""Flow is of colours: what is shaded by its nearness grows brighter without moving. Edges move
smoothly from ray to ray only where a ray is the mean of several samples."""

PERIOD_S = 0.1
"""Of the fields' steps."""


def with_memory(eye: RetinaSpec) -> PolicyContract:
    """The reference field's motions, an eye, and what the filters of its rays remember."""
    return replace(reference_contract(eye), state=memory_of(eye))


@dataclass(frozen=True)
class ViewingDirections:
    """Four mirror pairs of motion detectors that look where evolution wants them to."""

    ORIGIN: ClassVar[Origin] = Origin(
        "S. A. Huber, H. A. Mallot, H. H. Bülthoff, Evolution of the sensorimotor control in an "
        "autonomous agent, 1996",
        Fidelity.RECONSTRUCTED,
        remarks="Numbers of the source unknown; evolved anew, for contacts per metre.",
    )
    SEARCHED: ClassVar[Mapping[str, Span]] = {}

    detectors: Detectors = field(default_factory=partial(shipped, "evolved-viewing", Detectors))
    eye: RetinaSpec = FLOW_EYE
    period_s: float = PERIOD_S
    """Time between two decisions."""

    @property
    def contract(self) -> PolicyContract:
        """The reference field's motions."""
        return with_memory(self.eye)

    @cached_property
    def _wiring(self) -> Wiring:
        return wired([self.detectors], self.eye, self.period_s)

    def decide(self, retinas: RetinaBatch, memories: Memories) -> tuple[QValues, Actions, Memories]:
        """See `RememberingPolicy`."""
        seen = brightness(retinas)[np.newaxis]
        turn, following = wish(self._wiring, seen, memories[np.newaxis])
        return *steer(turn[0], self.detectors.dead_band), following[0]
