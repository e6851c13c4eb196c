"""What a training run knows of a learner, whichever its form; and what both forms share.

`Learner` is the interface of `online.learner.OnlineLearner` and `batched.learner.BatchedLearner`.
The functions below are their reports, their check for divergence and their part of a checkpoint.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.errors import UsageError
from reflexarc_trainer.config.train_config import TrainConfig

Arrays = dict[str, npt.NDArray[Any]]

WORLD = "world."
"""Prefix of the simulation's arrays among those of a learner."""
STAGE = "stage"
"""Name, in a checkpoint, of the number of the stage whose world its arrays are of."""

COUNTS_DTYPE = np.dtype(
    # Transitions of the whole run; contacts and progress along x in the present world.
    [("steps", np.int64), ("contacts", np.int64), ("distance_m", np.float64)],
    align=True,
)
"""What a learner has counted, all agents together; a report is the difference of two of these."""


@dataclass(frozen=True)
class Report:
    """What happened while learning since the last mark."""

    mean_abs_error: float
    """Mean of |δ|, the TD error (online), or of |G − Q|, the error of the λ-return (batched)."""
    contacts_per_100m: float
    """Contacts while learning, random actions included."""


class Learner(Protocol):
    """A learner at some step of its run."""

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
        """The exploration rate ε now."""
        ...

    @property
    def weights(self) -> npt.NDArray[np.float64]:
        """The learned weights, in the order of `policy/weights.py`: (parameters,)."""
        ...

    def run(self, steps: int) -> None:
        """Learn from `steps` more transitions, or from as many as one update takes if that is more.

        Raises:
            UsageError: the weights are no longer finite.
        """
        ...

    def report(self) -> Report:
        """What happened since the last mark."""
        ...

    def mark(self) -> None:
        """Let the next report begin here."""
        ...

    def arrays(self) -> Arrays:
        """Everything that the rest of the run depends on, by name."""
        ...

    def restore(self, arrays: Mapping[str, npt.NDArray[Any]]) -> None:
        """Continue from a state that `arrays` returned.

        Raises:
            UsageError: an array is missing or does not fit this run.
        """
        ...


def check_finite(weights: npt.NDArray[Any], step: int, config: TrainConfig) -> None:
    """Stop a run whose weights diverged.

    Args:
        weights: (parameters,).
        step: transitions learned from so far.
        config: the run.

    Raises:
        UsageError: a weight is infinite or NaN; the message names the settings to change.
    """
    if np.isfinite(weights).all():
        return
    learner = config.learner
    if learner.form == "online":
        online = learner.online
        settings = f"learner.online.step = {online.step!r}, alpha = {online.alpha:g}"
        advice = "use the bounded step or a smaller alpha"
    else:
        settings = f"learner.batched.learning_rate = {learner.batched.learning_rate:g}"
        advice = "use a smaller one"
    raise UsageError(
        f"learner: the weights are not finite after {step} steps ({settings}, network.output = "
        f"{config.network.output!r}); {advice}"
    )


def counts(steps: int, contacts: int, distance_m: float) -> npt.NDArray[np.void]:
    """One row of `COUNTS_DTYPE`: (1,)."""
    return np.array([(steps, contacts, distance_m)], COUNTS_DTYPE)


def report_between(
    before: npt.NDArray[np.void],
    now: npt.NDArray[np.void],
    sum_abs_error: float,
    config: TrainConfig,
    dt_s: float,
) -> Report:
    """The report on what lies between two counts.

    Args:
        before: counts at the last mark: (1,).
        now: counts: (1,).
        sum_abs_error: sum of the absolute errors in between.
        config: the run.
        dt_s: duration of a world step.
    """
    steps = int(now["steps"][0] - before["steps"][0])
    contacts = int(now["contacts"][0] - before["contacts"][0])
    distance_m = float(now["distance_m"][0] - before["distance_m"][0])
    world_steps = steps * config.learner.exploration.action_repeat
    return Report(
        mean_abs_error=sum_abs_error / max(1, steps),
        contacts_per_100m=100.0 * contacts / driven_m(config, dt_s, world_steps, distance_m),
    )


def driven_m(config: TrainConfig, dt_s: float, steps: float, distance_m: float) -> float:
    """The distance over which contacts are counted, all agents together, in metres.

    It is the progress along x, so that zigzagging does not improve a score. A body that turns may
    drive in any direction; for it the distance is the length of the path, at its constant speed.

    Args:
        config: says whether the body turns.
        dt_s: duration of a world step.
        steps: world steps, all agents together.
        distance_m: progress along x, all agents together.
    """
    if config.motion == "turning":
        return max(1e-9, steps * dt_s * config.forward_mps)
    return max(1e-9, distance_m)


def restore_arrays(mine: Mapping[str, npt.NDArray[Any]], arrays: Mapping[str, Any]) -> None:
    """Copy saved arrays into a learner's own of the same names.

    Raises:
        UsageError: one is missing, or of another shape or type.
    """
    for name, array in mine.items():
        saved = arrays.get(name)
        if saved is None or (saved.shape, saved.dtype) != (array.shape, array.dtype):
            got = "nothing" if saved is None else f"shape {saved.shape} of {saved.dtype}"
            raise UsageError(
                f"checkpoint: {name}: expected shape {array.shape} of {array.dtype}, got {got}; "
                "train anew"
            )
        array[...] = saved


def saved_stage(arrays: Mapping[str, npt.NDArray[Any]], stages: int) -> int:
    """The stage whose world the saved arrays belong to.

    Raises:
        UsageError: there is none, or no such stage.
    """
    saved = arrays.get(STAGE, np.zeros(0, np.int64))
    if saved.shape != (1,) or not 0 <= saved[0] < stages:
        raise UsageError(
            f"checkpoint: {STAGE}: expected 0 to {stages - 1}, got {saved.tolist()}; train anew"
        )
    return int(saved[0])


def world_arrays(arrays: Mapping[str, npt.NDArray[Any]]) -> Arrays:
    """The simulation's arrays among those of a learner, by the simulation's names."""
    return {k.removeprefix(WORLD): v for k, v in arrays.items() if k.startswith(WORLD)}
