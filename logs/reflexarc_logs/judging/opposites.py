"""Which actions are opposite: one goes the other way in at least one of the three speeds."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.contract.motion import Action


def are_opposite(a: Action, b: Action) -> bool:
    """Whether one turns, shifts or drives to the other side than the other: left and right.

    An action without a speed is opposite to none in that speed: straight on is no opposite of left.
    """
    return any(x * y < 0.0 for x, y in zip(ways(a), ways(b), strict=True))


def opposites(actions: Sequence[Action]) -> npt.NDArray[np.bool_]:
    """Which of them are opposite: (actions, actions)."""
    return np.array([[are_opposite(a, b) for b in actions] for a in actions])


def ways(action: Action) -> tuple[int, int, int]:
    """The signs of its linear, lateral and angular speed: −1, 0 or 1."""
    speeds = action.linear_mps, action.lateral_mps, action.angular_radps
    return tuple((speed > 0.0) - (speed < 0.0) for speed in speeds)  # type: ignore[return-value]  # three
