"""A closed loop of two motion detectors a side, whose weights evolved in the loop.

Source: probably T. R. Neumann, S. A. Huber and H. H. Bülthoff, *Minimalistic approach to 3D
obstacle avoidance behavior from simulated evolution*, 1997. Its abstract says: two correlation
detectors a side, weights adjusted by a genetic algorithm under closed-loop action and perception.
Adapted: both look along ±45°, with receptors 11.25° and 22.5° apart; the time constants, dead-band
and saturation, which could not be read, evolved beside the weights (`motion_steering.py`). Evolved
here by `python -m reflexarc_baselines.evolving closed-loop`.
"""

import math
from dataclasses import dataclass, field
from functools import partial
from typing import ClassVar

from reflexarc_baselines.baseline import Fidelity, Origin
from reflexarc_baselines.genome_files import shipped
from reflexarc_baselines.history.motion_steering import Detectors
from reflexarc_baselines.history.viewing_directions import ViewingDirections

BEARINGS_RAD = (math.pi / 4, math.pi / 4)
SEPARATIONS_RAD = (math.pi / 16, math.pi / 8)


@dataclass(frozen=True)
class ClosedLoop(ViewingDirections):
    """Two mirror pairs of motion detectors that look along ±45°."""

    ORIGIN: ClassVar[Origin] = Origin(
        "probably T. R. Neumann, S. A. Huber, H. H. Bülthoff, Minimalistic approach to 3D obstacle "
        "avoidance behavior from simulated evolution, 1997",
        Fidelity.RECONSTRUCTED,
        remarks="Only the abstract could be read; evolved anew, for contacts per metre.",
    )

    detectors: Detectors = field(default_factory=partial(shipped, "closed-loop", Detectors))
