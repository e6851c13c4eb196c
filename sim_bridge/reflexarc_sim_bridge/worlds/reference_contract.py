"""The contract of the reference field: its eye, its actions, its rate."""

import math

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec, Shading
from reflexarc_runtime.contract.motion import sideways_actions

WORLD_NAME = "reference-1"


SPEED_MPS = 1.0


def reference_retina() -> RetinaSpec:
    """The eye of the field: 16 rays over 180°, 5 m, grey, nearness, one frame."""
    return RetinaSpec(rays=16, fov_rad=math.pi, range_m=5.0, shading=Shading.NEARNESS)


def reference_contract(retina: RetinaSpec | None = None) -> PolicyContract:
    """A contract for the field: its actions and its speed, its own eye unless another is given."""
    return PolicyContract(
        retina=retina or reference_retina(), actions=sideways_actions(SPEED_MPS, SPEED_MPS)
    )
