"""`reflexarc train`: learns a policy."""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from reflexarc.terminal.output import aside, console, facts, print_json
from reflexarc.terminal.signals import StopFlag
from reflexarc_runtime.contract.stopping import check_speed
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.words.suggestion import pasteable

if TYPE_CHECKING:
    from reflexarc_trainer.config.train_config import TrainConfig
    from reflexarc_trainer.run.history import Row
    from reflexarc_trainer.run.train import TrainResult

_FIELDS = {
    "steps": "steps",
    "worlds": "worlds",
    "rays": "retina.rays",
    "max_input_age": "max_input_age_s",
    "radius": "body.footprint.radius_m",
    "deceleration": "body.deceleration_mps2",
    "delay": "body.actuation_delay_s",
    "hold": "hold_s",
    "margin": "margin",
    "lead": "least_lead",
    "stop_at": "validation.stop_at",
}
"""Flag → the field of the configuration that it is short for."""
_ONLY_BY_FLAG = {"preset": "--preset", "seed": "--seed", "init_from": "--init-from"}
"""Fields that name the run's folder, or are made of a file."""
_GIVEN_ONCE = {"init_from": "--init-from", "settings": "--set"} | {
    name: "--" + name.replace("_", "-") for name in _FIELDS
}
"""What a resumed run does not take, and its flag."""


@dataclass(frozen=True)
class TrainCommand:
    """Learn a reflex with SARSA(λ) and export it as one ONNX file.

    Writes policy.onnx (as the run left it), policy-best.onnx (best on validation worlds),
    report.md with its pictures, metrics.csv, config.json and a checkpoint. Ctrl-C keeps what was
    learned; --resume goes on from there to the same bits as a run that was never interrupted.

    Examples:
      reflexarc train
      reflexarc train --presets
      reflexarc train --preset paper --seed 3 --out runs/paper-3
      reflexarc train --out runs/paper-3 --resume
      reflexarc train --stop-at 5
      reflexarc train --preset lidar --radius 0.3 --deceleration 1 --delay 0.2
      reflexarc train --hold 0 --margin 0 --lead 0
      reflexarc train --worlds tier-05:1 tier-15:1 tier-25:2
      reflexarc train --rays 32
      reflexarc train --preset online --set learner.online.alpha=0.3 --set learner.gamma=0.8
      reflexarc train --set 'network.hidden=[64, 64]' --set retina.shading=colour
      reflexarc train --worlds forest --init-from runs/reflex-0/policy-best.onnx --steps 100000
    """

    preset: str = "reflex"
    """reflex: the default; paper: the paper's learner and eye; binocular: two eyes; rover: a body
    that turns; lidar, rover-lidar: for range scanners; and more, see --presets."""
    presets: bool = False
    """Say what each preset is for and what it reaches, and do nothing."""
    seed: int = 0
    """Seed of weights, exploration and world; the same seed gives the same bits."""
    steps: int | None = None
    """Transitions to learn from; the preset's by default."""
    worlds: tuple[str, ...] = ()
    """Worlds to learn in, one after another, names or files; NAME:SHARE for its share of the
    steps. The policy is measured in the last."""
    rays: int | None = None
    """Rays of each eye; the preset's by default. The network's first layer is as wide."""
    settings: Annotated[tuple[str, ...], tyro.conf.arg(name="set"), tyro.conf.UseAppendAction] = ()
    """FIELD=VALUE: any field of the configuration by its dotted name, as config.json has them and
    studies set them; several times for several. A wrong name is told the nearest."""
    max_input_age: float | None = None
    """Age in seconds up to which the policy takes inputs: it learns with a sensor that sends so
    late and so seldom. For a lidar: two of its periods and a little, or three."""
    radius: float | None = None
    """Radius of the body in metres; by default that of the world."""
    deceleration: float | None = None
    """How hard the body brakes and speeds up, m/s²; by default as in the world."""
    delay: float | None = None
    """Seconds after which the body obeys; by default as in the world."""
    hold: float | None = None
    """Seconds for which the policy does an action at least; the preset's by default."""
    margin: float | None = None
    """Share of the spread of the Q-values by which another action must win; the preset's."""
    lead: float | None = None
    """By how much the Q-value of another action must be larger, at least; the preset's."""
    allow_fast: bool = False
    """Learn to drive faster than the eye, all delays and the body's brakes allow."""
    init_from: Path | None = None
    """Begin with the weights of this policy, of the same eye, actions and network."""
    stop_at: float | None = None
    """End once so many contacts per 100 m on validation worlds are reached twice in a row."""
    tensorboard: bool = False
    """Write TensorBoard event files beside metrics.csv (extra: tensorboard)."""
    out: Path | None = None
    """Folder to write to; runs/<preset>-<seed> by default."""
    resume: bool = False
    """Go on with the run in --out."""
    json: bool = False
    """Print one JSON object at the end."""

    def run(self) -> int:
        """Train, and say what was learned."""
        if self.presets:
            return _tell_presets()
        config = self.config()  # before torch is loaded, which takes seconds
        from reflexarc.terminal.progress import show_progress
        from reflexarc_trainer.run.train import resume, train

        out = self.out or Path("runs") / f"{self.preset}-{self.seed}"
        with self._events(out) as measured, StopFlag() as stop, show_progress() as progress:
            if self.resume:
                result = resume(out, progress=progress, measured=measured, should_stop=stop)
            else:
                result = train(
                    config,
                    out,
                    init_from=self.init_from,
                    progress=progress,
                    measured=measured,
                    should_stop=stop,
                )
        self._tell(result, out)
        return 0

    def config(self) -> "TrainConfig":
        """What the flags ask for.

        Raises:
            UsageError: a flag does not fit, or no run can be made of it.
        """
        from dataclasses import replace

        from reflexarc_trainer.config.field_settings import with_settings
        from reflexarc_trainer.config.presets import preset_named

        self._check_resume()
        config = with_settings(replace(preset_named(self.preset), seed=self.seed), self._fields())
        warning = check_speed(config.contract(), allow=self.allow_fast)
        if warning:
            aside.print(f"reflexarc train: {warning}", soft_wrap=True)
        return config

    def _fields(self) -> dict[str, object]:
        """The fields that flags and `--set` name, and their values as a TOML file has them."""
        from reflexarc_trainer.config.setting_words import parse_settings

        given = {flag: getattr(self, flag) for flag in _FIELDS}
        by_flag = {_FIELDS[f]: v for f, v in given.items() if v is not None and v != ()}
        try:
            by_set = parse_settings(self.settings)
        except UsageError as error:
            raise UsageError(f"--set: {error}") from None
        for name in by_set:
            if instead := _ONLY_BY_FLAG.get(name):
                raise UsageError(f"--set {name}: cannot be set so; use {instead}")
            if name in by_flag:
                flag = next(_GIVEN_ONCE[flag] for flag, field in _FIELDS.items() if field == name)
                raise UsageError(f"--set {name}: set by {flag}, too; leave one of them out")
        return {name: list(v) if name == "worlds" else v for name, v in by_flag.items()} | by_set

    def _check_resume(self) -> None:
        for name, flag in _GIVEN_ONCE.items() if self.resume else ():
            if getattr(self, name) not in (None, ()):
                raise UsageError(f"{flag}: a resumed run goes on as it was begun; leave it out")

    def _events(self, out: Path) -> AbstractContextManager["Callable[[Row], None] | None"]:
        if not self.tensorboard:
            return nullcontext()
        from reflexarc_trainer.run.tensorboard_files import event_files

        return event_files(out)

    def _tell(self, result: "TrainResult", out: Path) -> None:
        if self.json:
            print_json(_summary(result))
            return
        rows: dict[str, object] = {
            "learned from": f"{result.steps:,} steps in {result.seconds:.1f} s",
            "validation worlds": _score(result.history[-1] if result.history else None),
            "policy": result.policy_path,
        }
        if result.best is not None:
            rows["best of them"] = _score(result.best)
            rows["best policy"] = result.best_policy_path
        console.print(facts(rows | {"report": out / "report.md"}))
        if result.reached:
            aside.print("ended early: --stop-at is reached")
        if result.interrupted:
            again = pasteable("reflexarc", "train", "--out", out, "--resume")
            aside.print(f"interrupted; go on with: {again}", soft_wrap=True)


def _summary(result: "TrainResult") -> dict[str, object]:
    last, best = result.history[-1] if result.history else None, result.best
    return {
        "policy": result.policy_path,
        "steps": result.steps,
        "seconds": result.seconds,
        "validation_contacts_per_100m": last and last.validation_contacts_per_100m,
        "best_policy": best and result.best_policy_path,
        "best_step": best and best.step,
        "best_validation_contacts_per_100m": best and best.validation_contacts_per_100m,
        "reached": result.reached,
        "interrupted": result.interrupted,
    }


def _score(point: "Row | None") -> str:
    if point is None:
        return "not measured yet"
    return f"{point.validation_contacts_per_100m:.2f} contacts per 100 m at step {point.step:,}"


def _tell_presets() -> int:
    from reflexarc_trainer.config.presets import HELP

    console.print(facts(dict(HELP)))
    return 0
