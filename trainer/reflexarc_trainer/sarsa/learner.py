"""A learner at some step of its run: what training, checkpoint and delivery know of it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.errors import UsageError
from reflexarc_trainer.config.train_config import TrainConfig

Arrays = dict[str, npt.NDArray[Any]]

WORLD = "world."
"""Before the names of a simulation's arrays."""


@dataclass(frozen=True)
class Report:
    """What happened while learning since the last mark."""

    mean_abs_error: float
    """Of the TD error online, of the λ-return batched."""
    contacts_per_100m: float


class Learner(Protocol):
    """Either form of the algorithm."""

    @property
    def config(self) -> TrainConfig:
        """The run."""
        ...

    @property
    def step(self) -> int:
        """Transitions learned from so far."""
        ...

    @property
    def epsilon(self) -> float:
        """Share of random actions now."""
        ...

    @property
    def weights(self) -> npt.NDArray[np.float64]:
        """What has been learned, in the order of `weights.py`: (parameters,)."""
        ...

    def run(self, steps: int) -> None:
        """Learn from `steps` more transitions, or from the fewest that can be learned from.

        Raises:
            UsageError: the weights are no longer finite.
        """
        ...

    def report(self) -> Report:
        """What happened since the last mark."""
        ...

    def mark(self) -> None:
        """The next report begins here."""
        ...

    def arrays(self) -> Arrays:
        """Everything that the rest of the run depends on, by name."""
        ...

    def restore(self, arrays: Mapping[str, npt.NDArray[Any]]) -> None:
        """Go on from what `arrays` gave.

        Raises:
            UsageError: an array is missing or of another shape.
        """
        ...


def check_finite(weights: npt.NDArray[Any], step: int, config: TrainConfig) -> None:
    """Refuse to go on with weights that are infinite or not numbers.

    Raises:
        UsageError: they are, with what may have caused it.
    """
    if np.isfinite(weights).all():
        return
    learner = config.learner
    if learner.form == "online":
        set_up = f"learner.online.step = {learner.online.step!r}, alpha = {learner.online.alpha:g}"
        advice = "use the bounded step or a smaller alpha"
    else:
        set_up = f"learner.batched.learning_rate = {learner.batched.learning_rate:g}"
        advice = "use a smaller one"
    raise UsageError(
        f"learner: the weights are not finite after {step} steps ({set_up}, network.output = "
        f"{config.network.output!r}); {advice}"
    )


def driven_m(config: TrainConfig, dt_s: float, steps: float, distance_m: float) -> float:
    """The metres over which contacts are counted, all agents together.

    Progress along x: nobody scores better by zigzagging. A body that turns has no x of its own, so
    for it the length of the path, which its uniform speed gives.

    Args:
        config: says whether it turns.
        dt_s: duration of a step.
        steps: of the world, all agents together.
        distance_m: their progress along x.
    """
    if config.motion == "turning":
        return max(1e-9, steps * dt_s * config.forward_mps)
    return max(1e-9, distance_m)


def restore_arrays(mine: Mapping[str, npt.NDArray[Any]], arrays: Mapping[str, Any]) -> None:
    """Copy saved arrays over those of the same name.

    Raises:
        UsageError: one is missing or of another shape.
    """
    for name, array in mine.items():
        if name not in arrays or arrays[name].shape != array.shape:
            raise UsageError(f"checkpoint: {name}: expected shape {array.shape}; train anew")
        array[...] = arrays[name]


def world_arrays(arrays: Mapping[str, npt.NDArray[Any]]) -> Arrays:
    """The simulation's arrays among those of a learner."""
    return {k.removeprefix(WORLD): v for k, v in arrays.items() if k.startswith(WORLD)}
