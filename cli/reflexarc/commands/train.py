"""`reflexarc train`: learn a reflex."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from reflexarc.output import aside, console, facts, print_json
from reflexarc.stop import StopFlag
from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from reflexarc_trainer.config import TrainConfig
    from reflexarc_trainer.train import TrainResult


@dataclass(frozen=True)
class Train:
    """Learn a reflex with SARSA(λ) and export it as one ONNX file.

    Writes policy.onnx, config.json, metrics.csv, curve.png and a checkpoint. Ctrl-C keeps what was
    learned; --resume goes on from there to the same bits as a run that was never interrupted.

    Examples:
      reflexarc train
      reflexarc train --preset paper --seed 3 --out runs/paper-3
      reflexarc train --out runs/paper-3 --resume
    """

    preset: str = "reflex"
    """reflex: the paper's learner with the reference eye; paper: with the paper's literal eye;
    lidar: for range scanners."""
    seed: int = 0
    """Seed of weights, exploration and world; the same seed gives the same bits."""
    steps: int | None = None
    """Transitions to learn from; the preset's by default."""
    out: Path | None = None
    """Folder to write to; runs/<preset>-<seed> by default."""
    resume: bool = False
    """Go on with the run in --out."""
    json: bool = False
    """Print one JSON object at the end."""

    def run(self) -> int:
        """Train, and say what was learned."""
        from reflexarc.training_progress import show_progress
        from reflexarc_trainer.train import resume, train

        if self.resume and self.steps is not None:
            raise UsageError("--steps: a resumed run ends where it was meant to; leave it out")
        config = self._config()
        out = self.out or Path("runs") / f"{self.preset}-{self.seed}"
        with StopFlag() as stop, show_progress() as progress:
            if self.resume:
                result = resume(out, progress=progress, should_stop=stop)
            else:
                result = train(config, out, progress=progress, should_stop=stop)
        self._tell(result, out)
        return 0

    def _config(self) -> "TrainConfig":
        from dataclasses import replace

        from reflexarc_trainer.presets import preset_named

        config = preset_named(self.preset)
        steps = config.steps if self.steps is None else self.steps
        return replace(config, seed=self.seed, steps=steps)

    def _tell(self, result: "TrainResult", out: Path) -> None:
        validation = result.history[-1].validation_contacts_per_100m if result.history else None
        if self.json:
            print_json(
                {
                    "policy": result.policy_path,
                    "steps": result.steps,
                    "seconds": result.seconds,
                    "validation_contacts_per_100m": validation,
                    "interrupted": result.interrupted,
                }
            )
            return
        console.print(
            facts(
                {
                    "learned from": f"{result.steps:,} steps in {result.seconds:.1f} s",
                    "validation worlds": _rate(validation),
                    "policy": result.policy_path,
                    "curve": out / "curve.png",
                }
            )
        )
        if result.interrupted:
            aside.print(f"interrupted; go on with: reflexarc train --out {out} --resume")


def _rate(contacts_per_100m: float | None) -> str:
    if contacts_per_100m is None:
        return "not measured yet"
    return f"{contacts_per_100m:.2f} contacts per 100 m (never steering: 36.0)"
