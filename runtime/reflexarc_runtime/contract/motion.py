"""The motions that a policy can choose among."""

import math
from dataclasses import dataclass

from reflexarc_runtime.config.checks import require
from reflexarc_runtime.errors import ContractError


@dataclass(frozen=True)
class Action:
    """One motion that the policy can choose, in the agent's frame."""

    name: str
    linear_mps: float
    lateral_mps: float
    angular_radps: float = 0.0

    def __post_init__(self) -> None:
        speeds = (self.linear_mps, self.lateral_mps, self.angular_radps)
        finite = all(map(math.isfinite, speeds))
        require(finite, f"action {self.name!r}", "finite", speeds, ContractError)

    @property
    def stands(self) -> bool:
        """Whether all three speeds are 0."""
        return self.linear_mps == self.lateral_mps == self.angular_radps == 0.0


def sideways_actions(forward_mps: float = 1.0, lateral_mps: float = 1.0) -> tuple[Action, ...]:
    """The paper's actions: stay, left, right at uniform forward speed.

    In this order a tie of all values stays on course (winner takes all, the first one wins).
    """
    return (
        Action("stay", forward_mps, 0.0),
        Action("left", forward_mps, lateral_mps),
        Action("right", forward_mps, -lateral_mps),
    )
