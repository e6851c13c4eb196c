"""A training run, and what it leaves in its folder.

    policy.onnx      the policy, whole: see `export.py`
    config.json      the resolved configuration, its hash, versions and commit
    metrics.csv      one row a validation point: see `history.py`
    curve.png        the same as a picture
    checkpoint.npz   where the run stands: `resume` goes on from it to the same bits

Each file is whole or absent. An interrupted run leaves all of them, of what it learned so far; one
that is killed leaves the last validation point's checkpoint and metrics.
"""

import json
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from reflexarc_trainer import checkpoint
from reflexarc_trainer.config import TrainConfig
from reflexarc_trainer.curve import draw_curve
from reflexarc_trainer.delivery import deliver
from reflexarc_trainer.files import write_atomically
from reflexarc_trainer.forms import new_learner
from reflexarc_trainer.history import Row, to_csv
from reflexarc_trainer.learner import Learner
from reflexarc_trainer.provenance import commit, versions
from reflexarc_trainer.validation import validate

CHUNK_STEPS = 20_000
"""Transitions between two looks at `should_stop`."""

POLICY, CONFIG, METRICS = "policy.onnx", "config.json", "metrics.csv"
CURVE, CHECKPOINT = "curve.png", "checkpoint.npz"


@dataclass(frozen=True)
class Progress:
    """Where a run stands."""

    step: int
    steps: int
    epsilon: float
    seconds: float
    last: Row | None
    """The last validation point."""


@dataclass(frozen=True)
class TrainResult:
    """What a run gave."""

    policy_path: Path
    steps: int
    """Transitions learned from."""
    seconds: float
    history: tuple[Row, ...]
    interrupted: bool


ProgressCallback = Callable[[Progress], None]


def train(
    config: TrainConfig,
    out: Path,
    *,
    progress: ProgressCallback | None = None,
    should_stop: Callable[[], bool] | None = None,
) -> TrainResult:
    """Train from the start and write everything into `out`, over what lies there.

    Args:
        config: the run.
        out: its folder, made if need be.
        progress: told where the run stands, every `CHUNK_STEPS` steps.
        should_stop: asked as often; True ends the run as Ctrl-C does.

    Raises:
        WorldError: the world or the eye is not supported.
        UsageError: the weights diverged.
        PolicyError: the policy could not be exported faithfully.
    """
    return _Run(out, new_learner(config), [], progress, should_stop).go()


def resume(
    out: Path,
    *,
    progress: ProgressCallback | None = None,
    should_stop: Callable[[], bool] | None = None,
) -> TrainResult:
    """Continue the run in `out` to the end that it was given; arguments as for `train`.

    Raises:
        UsageError: there is no checkpoint in `out`.
    """
    saved = checkpoint.load(out / CHECKPOINT)
    return _Run(out, saved.learner(), saved.history, progress, should_stop).go()


@dataclass
class _Run:
    out: Path
    learner: Learner
    history: list[Row]
    progress: ProgressCallback | None
    should_stop: Callable[[], bool] | None
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
        self._write_config()
        try:
            interrupted = not self._learn()
        except KeyboardInterrupt:
            interrupted = True
        self._save()
        write_atomically(self.out / CURVE, draw_curve(self.config, self.history))
        path = self.out / POLICY
        deliver(self.learner, self.history, path)
        history = tuple(self.history)
        return TrainResult(path, self.learner.step, self.seconds, history, interrupted)

    def _learn(self) -> bool:
        """True when the end is reached, False when someone wants to stop."""
        for target in validation_steps(self.config)[len(self.history) :]:
            while self.learner.step < target:
                if self.should_stop is not None and self.should_stop():
                    return False
                self.learner.run(min(CHUNK_STEPS, target - self.learner.step))
                self._tell()
            self._measure()
            self._save()
        return True

    def _measure(self) -> None:
        score = validate(self.learner.network(), self.config)
        report = self.learner.report()
        self.history.append(
            Row(
                step=self.learner.step,
                seconds=self.seconds,
                epsilon=self.learner.epsilon,
                mean_abs_error=report.mean_abs_error,
                learning_contacts_per_100m=report.contacts_per_100m,
                validation_contacts_per_100m=score,
            )
        )

    def _tell(self) -> None:
        if self.progress is not None:
            last = self.history[-1] if self.history else None
            step, steps = self.learner.step, self.config.steps
            self.progress(Progress(step, steps, self.learner.epsilon, self.seconds, last))

    def _write_config(self) -> None:
        document = {
            "config": self.config.resolved(),
            "config_hash": self.config.hash,
            "versions": versions(),
            "commit": commit(),
        }
        write_atomically(self.out / CONFIG, (json.dumps(document, indent=2) + "\n").encode())

    def _save(self) -> None:
        checkpoint.save(self.out / CHECKPOINT, self.learner, self.history)
        write_atomically(self.out / METRICS, to_csv(self.history))


def validation_steps(config: TrainConfig) -> list[int]:
    """The steps after which the policy is measured; the last is the end of the run."""
    points = min(config.validation.points, config.steps)
    return [config.steps * (point + 1) // points for point in range(points)]
