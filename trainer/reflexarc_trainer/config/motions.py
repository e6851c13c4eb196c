"""How the bodies of the presets move: what their actions are.

In the order stay, left, right: a tie of all values stays on course.
"""

from typing import Literal

from reflexarc_runtime.contract import Action

Motion = Literal["sideways", "turning"]


def turning_actions(forward_mps: float, angular_radps: float) -> tuple[Action, ...]:
    """Stay, left, right at uniform forward speed, for a body that turns in place of shifting."""
    return (
        Action("stay", forward_mps, 0.0),
        Action("left", forward_mps, 0.0, angular_radps),
        Action("right", forward_mps, 0.0, -angular_radps),
    )
