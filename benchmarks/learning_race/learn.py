"""One run of a contender, from its first weights to its time limit.

Schedules (ε, learning rates) need the length of the run. Those of our learners count steps, whose
number is computed from the measured speed; those of Stable-Baselines3 follow the clock.
"""

import math
from copy import deepcopy
from dataclasses import replace
from typing import Any

from learning_race.contenders import AnyLearner, Contender, Ours, Theirs
from learning_race.frozen import of_ours, of_theirs
from learning_race.judge import Clock, Judge

WARM_UP_S = 1.5
_FOREVER = 1 << 60
"""Steps of a run that the judge ends."""
_SCHEDULES = ("lr_schedule", "exploration_schedule", "clip_range", "clip_range_vf")
"""Attributes of a model that are functions of the share of the run that is left."""
_MARGIN = 0.9
"""Share of the time to the next look that a chunk of steps should take."""


def warm_up(contender: Contender) -> float:
    """Learn for a moment, to compile and load everything; returns world steps per second."""
    learner = contender.learner
    if isinstance(learner, Ours):
        _speed(_paced(learner, 1.0), math.inf)  # its speed is not used: this compiles
    rate = _speed(learner, WARM_UP_S / 3)
    return _speed(_paced(learner, WARM_UP_S * rate), WARM_UP_S)


def in_time(contender: Contender, rate: float) -> AnyLearner:
    """The contender's learner, with schedules that fit its time limit.

    Args:
        contender: the contender.
        rate: its world steps per second.
    """
    return _paced(contender.learner, rate * contender.budget_s if contender.is_paced else 0.0)


def learn(learner: AnyLearner, seed: int, judge: Judge) -> None:
    """Learn until the judge or the number of steps ends the run; look once more at the end."""
    if isinstance(learner, Ours):
        _learn_ours(learner, seed, judge)
    else:
        _learn_theirs(learner, seed, judge)


def steps_a_transition(ours: Ours) -> int:
    """World steps per transition of one of our learners."""
    return ours.config.learner.exploration.action_repeat


def _speed(learner: AnyLearner, seconds: float) -> float:
    """World steps per second, measured in a run of at most `seconds`."""
    judge = Judge(Clock(), seconds, rate=lambda policy: 0.0)
    learn(learner, seed=0, judge=judge)
    return judge.looks[-1].world_steps / judge.looks[-1].seconds


def _paced(learner: AnyLearner, world_steps: float) -> AnyLearner:
    if isinstance(learner, Theirs) or not world_steps:
        return learner
    steps = max(1, round(world_steps / steps_a_transition(learner)))
    return Ours(replace(learner.config, steps=steps))


def _learn_ours(ours: Ours, seed: int, judge: Judge) -> None:
    from reflexarc_trainer.sarsa.forms import new_learner

    config = replace(ours.config, seed=seed)
    learner, repeat = new_learner(config), steps_a_transition(ours)
    began_s = judge.clock.seconds
    while learner.step < config.steps and not judge.is_over:
        rate = learner.step / max(1e-9, judge.clock.seconds - began_s)  # transitions per second
        left_s = min(judge.due_s, judge.limit_s) - judge.clock.seconds
        learner.run(max(1, min(config.steps - learner.step, int(_MARGIN * rate * left_s))))
        if judge.is_due:
            judge.look(lambda: of_ours(learner), learner.step * repeat)
    judge.look(lambda: of_ours(learner), learner.step * repeat)


def _learn_theirs(theirs: Theirs, seed: int, judge: Judge) -> None:
    from learning_race.callback import Looks

    model = new_model(theirs, seed, judge)
    model.learn(_FOREVER, callback=Looks(judge, theirs))
    frozen = of_theirs(model, theirs.input_power)
    judge.look(lambda: frozen, model.num_timesteps * theirs.held_steps)


def new_model(theirs: Theirs, seed: int, judge: Judge) -> Any:
    """A rival before its first step, with schedules that end at the judge's time limit."""
    from learning_race.field import FieldVecEnv

    world = {"input_power": theirs.input_power, "held_steps": theirs.held_steps}
    env = FieldVecEnv(theirs.agents, seed, **world)
    model = algorithm(theirs.algorithm)(
        "MlpPolicy", env, seed=seed, device="cpu", **_settings(theirs)
    )
    _follow_clock(model, judge)
    return model


def algorithm(name: str) -> Any:
    """The class of an algorithm's name.

    Raises:
        SystemExit: it is in sb3-contrib, which is not installed.
    """
    import stable_baselines3

    if hasattr(stable_baselines3, name):
        return getattr(stable_baselines3, name)
    try:
        import sb3_contrib
    except ImportError:
        raise SystemExit(f"learning: {name} is in sb3-contrib: pip install sb3-contrib") from None
    return getattr(sb3_contrib, name)


def _settings(theirs: Theirs) -> dict[str, Any]:
    """Arguments for the model; a deep copy, as the library writes into `policy_kwargs`."""
    settings, peak = deepcopy(dict(theirs.settings)), theirs.falling_rate
    if peak is not None:
        settings["learning_rate"] = lambda left: max(0.0, left) * peak
    return settings


def _follow_clock(model: Any, judge: Judge) -> None:
    """Give the model's schedules the share of the time that is left, not that of the steps."""

    def by_clock(schedule: Any) -> Any:
        return lambda _: schedule(max(0.0, 1.0 - judge.clock.seconds / judge.limit_s))

    for name in _SCHEDULES:
        schedule = getattr(model, name, None)
        if callable(schedule):
            setattr(model, name, by_clock(schedule))
