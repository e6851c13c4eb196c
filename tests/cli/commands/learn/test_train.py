"""`reflexarc train`: what its flags become, and what it says."""

import json
from pathlib import Path

import pytest

from reflexarc.commands.learn.train import TrainCommand
from reflexarc.main import main
from reflexarc.terminal.progress import said_of, show_progress
from reflexarc_runtime.contract.body_spec import BodySpec, Footprint
from reflexarc_runtime.errors import ReflexarcError, UsageError
from reflexarc_runtime.policy.policy import load_policy
from reflexarc_trainer.config.presets import HELP, LEAST_LEAD, preset_named
from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.run.train import TrainingProgress


def configured(command: TrainCommand) -> TrainConfig:
    return command.config()


def test_without_flags_it_is_the_preset() -> None:
    assert configured(TrainCommand()) == preset_named("reflex")
    assert configured(TrainCommand(preset="rover")) == preset_named("rover")


def test_flags_change_what_they_name() -> None:
    config = configured(
        TrainCommand(seed=3, steps=9, worlds=("tier-05:1", "tier-15:3"), stop_at=5.0)
    )
    assert (config.seed, config.steps, config.validation.stop_at) == (3, 9, 5.0)
    assert [(world.name, world.share) for world in config.worlds] == [
        ("tier-05", 1),
        ("tier-15", 3),
    ]


def test_the_body_and_the_sensor_are_in_the_contract() -> None:
    command = TrainCommand(max_input_age=0.4, radius=0.3, deceleration=1.5, delay=0.2)
    config = configured(command)
    contract, world = config.contract(), config.goal_world.drawn(0)
    assert contract.max_input_age_s == 0.4
    assert contract.body == BodySpec(Footprint(radius_m=0.3), 0.2, 1.5) == world.body
    assert world.gap_steps == 4


def test_what_is_not_said_of_a_body_is_that_of_the_world() -> None:
    body = configured(TrainCommand(preset="rover", radius=0.3)).contract().body
    assert body == BodySpec(Footprint(radius_m=0.3), 0.1, 2.0)


def test_a_body_that_cannot_stand_before_what_it_sees_is_refused_until_a_flag_allows_it(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """1.41 m/s · 0.22 s + 1.41² / (2 · 0.2) = 5.31 m, of 5 m."""
    with pytest.raises(ReflexarcError, match=r"needs 5\.31 m .* sees 5 m .*--allow-fast"):
        configured(TrainCommand(deceleration=0.2))
    config = configured(TrainCommand(deceleration=0.2, allow_fast=True))
    assert config.contract().body.deceleration_mps2 == 0.2
    assert not capsys.readouterr().err


@pytest.mark.parametrize(
    "flags",
    [
        {"steps": 5},
        {"radius": 0.0},
        {"max_input_age": 0.3},
        {"worlds": ("plane",)},
        {"init_from": Path("p.onnx")},
        {"stop_at": 0.0},
        {"rays": 8},
        {"settings": ("steps=5",)},
    ],
)
def test_resumed_run_takes_no_flag_that_it_was_begun_with(flags: dict[str, object]) -> None:
    name = next(iter(flags)).replace("_", "-").replace("settings", "set")
    with pytest.raises(UsageError, match=f"--{name}: a resumed run goes on as it was begun"):
        configured(TrainCommand(resume=True, **flags))  # type: ignore[arg-type]  # one flag each


def test_presets_are_told_with_what_they_reach(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["train", "--presets"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert all(name in said for name in HELP)
    assert said.count("contacts per 100 m") >= 4


def test_short_run_says_both_policies(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["train", "--preset", "online", "--steps", "200", "--out", str(tmp_path), "--json"]
    assert main(words) == 0
    said = json.loads(capsys.readouterr().out)
    assert Path(said["policy"]).is_file()
    assert Path(said["best_policy"]).name == "policy-best.onnx"
    assert said["best_validation_contacts_per_100m"] <= said["validation_contacts_per_100m"]
    assert (said["steps"], said["reached"], said["interrupted"]) == (200, False, False)


def test_progress_says_rate_exploration_error_and_contacts(
    capsys: pytest.CaptureFixture[str],
) -> None:
    said = said_of(TrainingProgress(10, 100, 0.5, 1.0, 250_000.0, 0.125, None))
    assert said == "250 k steps/s  ε 0.50  error 0.125"
    with show_progress() as tell:
        tell(TrainingProgress(10, 100, 0.5, 1.0, 250_000.0, 0.125, None))


def test_holds_are_the_presets_unless_given() -> None:
    kept = configured(TrainCommand(hold=0.1)).contract()
    assert (kept.hold_s, kept.margin, kept.least_lead) == (0.1, 0.0, LEAST_LEAD)
    given = configured(TrainCommand(hold=0.0, margin=0.2, lead=0.0)).contract()
    assert (given.hold_s, given.margin, given.least_lead) == (0.0, 0.2, 0.0)
    with pytest.raises(UsageError, match="hold_s: expected"):
        configured(TrainCommand(hold=-0.1))


def test_rays_and_any_other_field_are_set(tmp_path: Path) -> None:
    """Given several times; the run's folder says what came of it, and the policy is so wide."""
    words = ["--preset", "online", "--rays", "7", "--steps", "200", "--out", str(tmp_path)]
    sets = ["--set", "learner.online.alpha=0.3", "--set", "retina.shading=colour"]
    assert main(["train", *words, *sets, "--json"]) == 0
    config = json.loads((tmp_path / "config.json").read_text())["config"]
    assert (config["retina"]["rays"], config["retina"]["shading"]) == (7, "colour")
    assert config["learner"]["online"]["alpha"] == 0.3
    policy = load_policy(tmp_path / "policy.onnx", backend="numpy")
    assert policy.contract.retina.shape == (1, 7, 1)


@pytest.mark.parametrize(
    ("flags", "complaint"),
    [
        ({"settings": ("seed=3",)}, "--set seed: cannot be set so; use --seed"),
        ({"settings": ("steps=3",), "steps": 4}, "--set steps: set by --steps, too"),
        ({"settings": ("retina.rays=3",), "rays": 4}, "--set retina.rays: set by --rays, too"),
        ({"settings": ("gamma",)}, "--set: expected FIELD=VALUE"),
        ({"rays": 0}, "retina.rays: expected 1 to 4096, got 0"),
    ],
)
def test_settings_that_say_two_things_are_refused(flags: dict[str, object], complaint: str) -> None:
    with pytest.raises(UsageError, match=complaint):
        configured(TrainCommand(**flags))  # type: ignore[arg-type]  # those of the case
