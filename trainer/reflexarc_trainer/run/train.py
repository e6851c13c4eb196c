"""The loop of a training run: learn, validate, save; at the end, export and report.

An interrupted run writes all files of `run_folder.py` for what it has learned so far. A run that is
killed leaves checkpoint and metrics of its last validation point.
"""

import dataclasses
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.policy.warm_start import weights_of
from reflexarc_trainer.policy.weights import Weights, network_of
from reflexarc_trainer.run.history import Row, best_of, has_reached
from reflexarc_trainer.run.run_folder import RunFolder
from reflexarc_trainer.run.validation import validate
from reflexarc_trainer.sarsa.forms import new_learner
from reflexarc_trainer.sarsa.learner_interface import Learner

CHUNK_STEPS = 20_000
"""Transitions between two calls of `should_stop`."""


@dataclass(frozen=True)
class TrainingProgress:
    """How far a run has come."""

    step: int
    steps: int
    """Transitions of the whole run."""
    epsilon: float
    seconds: float
    """Wall-clock time of the run, without interruptions."""
    steps_per_s: float
    """Transitions per second of learning, since the last call."""
    mean_abs_error: float
    """Mean of |δ| (online) or of |G − Q| (batched) since the last validation point."""
    last: Row | None
    """The last validation point."""


@dataclass(frozen=True)
class TrainResult:
    """The outcome of a run."""

    policy_path: Path
    """The policy with the last weights."""
    steps: int
    """Transitions learned from."""
    seconds: float
    """Wall-clock time of the run, without interruptions."""
    history: tuple[Row, ...]
    """The validation points."""
    interrupted: bool
    """Whether Ctrl-C or `should_stop` ended it."""
    best: Row | None = None
    """The best validation point, that of `best_policy_path`; None before the first point."""
    reached: bool = False
    """Whether the run reached `validation.stop_at`."""

    @property
    def best_policy_path(self) -> Path:
        """The policy of the best validation point; there is none before the first point."""
        return RunFolder(self.policy_path.parent).best_policy


ProgressCallback = Callable[[TrainingProgress], None]
RowCallback = Callable[[Row], None]


def train(
    config: TrainConfig,
    out: Path | str,
    *,
    init_from: Path | str | None = None,
    progress: ProgressCallback | None = None,
    measured: RowCallback | None = None,
    should_stop: Callable[[], bool] | None = None,
) -> TrainResult:
    """Train from the start; the results of an earlier run in `out` are removed.

    Args:
        config: the run.
        out: folder for its files, made if need be.
        init_from: a policy file that gives the initial weights; its hash becomes part of the
            configuration.
        progress: called every `CHUNK_STEPS` steps.
        measured: called with each validation point.
        should_stop: called as often as `progress`; True ends the run as Ctrl-C does.

    Raises:
        WorldError: a world does not exist, or does not support the eye.
        UsageError: the weights diverged; or `init_from` has another eye or network.
        PolicyError: the backends do not agree on the policy; or `init_from` is not a policy.
    """
    weights: Weights | None = None
    if init_from is not None:
        weights, name = weights_of(Path(init_from), config)
        config = dataclasses.replace(config, init_from=name)
    run = _Run(RunFolder(Path(out)), new_learner(config, weights), progress, measured, should_stop)
    run.folder.begin(config)
    return run.go()


def resume(
    out: Path | str,
    *,
    progress: ProgressCallback | None = None,
    measured: RowCallback | None = None,
    should_stop: Callable[[], bool] | None = None,
) -> TrainResult:
    """Continue the run in `out` up to its configured number of steps; arguments as for `train`.

    Raises:
        UsageError: `out` has no checkpoint of this version.
    """
    folder = RunFolder(Path(out))
    saved = folder.load()
    run = _Run(folder, saved.learner(), progress, measured, should_stop, saved.history, saved.best)
    return run.go()


@dataclass
class _Run:
    folder: RunFolder
    learner: Learner
    progress: ProgressCallback | None
    measured: RowCallback | None
    should_stop: Callable[[], bool] | None
    history: list[Row] = field(default_factory=list)
    best: Weights = field(default_factory=lambda: np.empty(0))
    started_s: float = field(default_factory=time.perf_counter)

    def __post_init__(self) -> None:
        self.started_s -= self.history[-1].seconds if self.history else 0.0

    @property
    def config(self) -> TrainConfig:
        return self.learner.config

    @property
    def seconds(self) -> float:
        return time.perf_counter() - self.started_s

    def go(self) -> TrainResult:
        try:
            interrupted = not self._learn()
        except KeyboardInterrupt:
            interrupted = True
        self.folder.save(self.learner, self.history, self.best)
        self.folder.finish(self.learner, self.history, self.best)
        return TrainResult(
            policy_path=self.folder.policy,
            steps=self.learner.step,
            seconds=self.seconds,
            history=tuple(self.history),
            interrupted=interrupted,
            best=best_of(self.history),
            reached=self._has_reached(),
        )

    def _learn(self) -> bool:
        """Learn and validate; returns False if `should_stop` ended the run before its end."""
        for target in validation_steps(self.config)[len(self.history) :]:
            if self._has_reached():
                break
            while self.learner.step < target:
                if self.should_stop is not None and self.should_stop():
                    return False
                self._learn_until(target)
            self._measure()
        return True

    def _learn_until(self, target: int) -> None:
        """Learn one chunk, at most up to step `target`."""
        before, began_s = self.learner.step, time.perf_counter()
        self.learner.run(min(CHUNK_STEPS, target - before))
        rate = (self.learner.step - before) / max(1e-9, time.perf_counter() - began_s)
        if self.progress is not None:
            self.progress(self._progress(rate))

    def _measure(self) -> None:
        """Validate, and save at once: a run that is killed can continue from here."""
        score, report = validate(network_of(self.learner), self.config), self.learner.report()
        self.learner.mark()
        row = Row(
            step=self.learner.step,
            seconds=self.seconds,
            epsilon=self.learner.epsilon,
            mean_abs_error=float(report.mean_abs_error),
            learning_contacts_per_100m=float(report.contacts_per_100m),
            validation_contacts_per_100m=score,
        )
        self.history.append(row)
        if best_of(self.history) is row:
            self.best = self.learner.weights.copy()
        if self.measured is not None:
            self.measured(row)
        self.folder.save(self.learner, self.history, self.best)

    def _progress(self, steps_per_s: float) -> TrainingProgress:
        return TrainingProgress(
            step=self.learner.step,
            steps=self.config.steps,
            epsilon=self.learner.epsilon,
            seconds=self.seconds,
            steps_per_s=steps_per_s,
            mean_abs_error=self.learner.report().mean_abs_error,
            last=self.history[-1] if self.history else None,
        )

    def _has_reached(self) -> bool:
        return has_reached(self.history, self.config.validation.stop_at)


def validation_steps(config: TrainConfig) -> list[int]:
    """The steps after which the policy is validated; the last is the end of the run."""
    points = min(config.validation.points, config.steps)
    return [config.steps * (point + 1) // points for point in range(points)]
