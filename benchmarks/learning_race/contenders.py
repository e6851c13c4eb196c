"""The contenders of the race and their settings; `tuning.md` lists the trials that led to them.

All have the reference field's eye and worlds. Our learners have one hidden layer of 64 or 63 units,
except `reflex-deep-60s`, which has two, as the rivals have by default. The tuned rivals have our
input curve (the square), our repeated actions (three world steps per action while learning), our
discount, a falling learning rate and one thread of torch (two were not faster in the one trial).
`online-3s` and `reflex-60s` have a larger discount; `reflex-60s` repeats each action twice and
takes contacts as terminal. The matched rivals are the tuned ones with the paper's network, 16–10–3.
The default rivals have their library's settings, which do not include the number of worlds; with
four, PPO was best.
"""

import hashlib
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, get_args

from reflexarc_trainer.config.learner_config import TdTarget
from reflexarc_trainer.config.presets import PRESETS
from reflexarc_trainer.config.train_config import TrainConfig

WORLDS_OF_DEFAULTS = 4


@dataclass(frozen=True)
class Ours:
    """One of our learners."""

    config: TrainConfig


@dataclass(frozen=True)
class Theirs:
    """An algorithm of Stable-Baselines3 or sb3-contrib."""

    algorithm: str
    """Name of its class."""
    agents: int = WORLDS_OF_DEFAULTS
    """Number of worlds that run at once."""
    settings: Mapping[str, Any] = field(default_factory=dict)
    """Settings that differ from the library's defaults."""
    falling_rate: float | None = None
    """First learning rate, which falls to 0 over the run; None: the library's constant one."""
    input_power: int = 1
    held_steps: int = 1
    """World steps per action."""
    torch_threads: int = 1


AnyLearner = Ours | Theirs


@dataclass(frozen=True)
class Contender:
    """A learner with its time limit."""

    name: str
    group: str
    """One of ours, ablation, tuned, default, matched."""
    learner: AnyLearner
    budget_s: float
    is_paced: bool = True
    """Whether our learner's number of steps is set to fill the time; else its configuration's."""
    cores: int = 2
    stops_at: float | None = None
    """A level at which the run ends, if any."""

    @property
    def settings_hash(self) -> str:
        """Hash of all settings."""
        return hashlib.sha256(repr(self).encode()).hexdigest()[:16]


def named(name: str) -> Contender:
    """The contender of a name.

    Raises:
        SystemExit: no contender has this name.
    """
    for contender in CONTENDERS:
        if contender.name == name:
            return contender
    known = ", ".join(contender.name for contender in CONTENDERS)
    print(
        f"learning: --contenders: no contender is named {name!r}; known: {known}", file=sys.stderr
    )
    raise SystemExit(2)


def _reflex(
    steps: int | None = None,
    *,
    hidden: tuple[int, ...] = (64,),
    averaged_weights: float = 0.95,
    epsilon_start: float = 1.0,
    target: str = "sampled",
    **batched: Any,
) -> Ours:
    """The preset `reflex` with some settings changed."""
    preset = PRESETS["reflex"]
    exploration = replace(preset.learner.exploration, epsilon_start=epsilon_start)
    learner = replace(
        preset.learner,
        averaged_weights=averaged_weights,
        target=target,
        exploration=exploration,
        batched=replace(preset.learner.batched, **batched),
    )
    network = replace(preset.network, hidden=hidden)
    return Ours(replace(preset, steps=steps or preset.steps, network=network, learner=learner))


def _changed(ours: Ours, action_repeat: int, **learner: Any) -> Ours:
    """The same with some of the learner's settings and the repetition of actions changed."""
    config = ours.config
    exploration = replace(config.learner.exploration, action_repeat=action_repeat)
    changed = replace(config.learner, exploration=exploration, **learner)
    return Ours(replace(config, learner=changed))


def _tuned(algorithm: str, agents: int, rate: float, **settings: Any) -> Theirs:
    shared = {"falling_rate": rate, "input_power": 2, "held_steps": 3}
    return Theirs(algorithm, agents, {"gamma": 0.9, **settings}, **shared)


def _with_hidden(learner: Theirs, hidden: int) -> Theirs:
    """The same with one hidden layer."""
    policy = {**learner.settings.get("policy_kwargs", {}), "net_arch": [hidden]}
    return replace(learner, settings={**learner.settings, "policy_kwargs": policy})


_PPO = _tuned("PPO", 512, 3e-3, n_steps=32, batch_size=4096, n_epochs=4, gae_lambda=0.8)
_PPO_SHORT = _tuned("PPO", 256, 5e-3, n_steps=16, batch_size=512, n_epochs=4, gae_lambda=0.8)
_REPLAY = {
    "batch_size": 512,
    "buffer_size": 200_000,
    "train_freq": 1,
    "learning_starts": 2048,
    "target_update_interval": 2000,
    "exploration_final_eps": 0.02,
}
_OFTEN = {"batch_size": 256, "learning_starts": 512, "target_update_interval": 500}
_REPLAY_SHORT = {**_REPLAY, **_OFTEN}
_DQN = _tuned("DQN", 64, 2e-3, exploration_fraction=0.1, **_REPLAY)
_DQN_SHORT = _tuned("DQN", 32, 3e-3, exploration_fraction=0.1, **_REPLAY_SHORT)
_QRDQN = _tuned(
    "QRDQN",
    32,
    3e-3,
    exploration_fraction=0.1,
    max_grad_norm=10,
    policy_kwargs={"n_quantiles": 8},
    **_REPLAY_SHORT,
)
_QUICK = _reflex(
    1 << 16,
    averaged_weights=0.8,
    epsilon_start=0.3,
    agents=16,
    shard_agents=16,
    rollout_steps=8,
    minibatches=8,
    learning_rate=7e-3,
)
_LONG = _changed(
    _reflex(agents=512, averaged_weights=0.999),
    action_repeat=2,
    gamma=0.93,
    trace_decay=0.65,
    after_contact="terminal",
)
_DEEP = _reflex(agents=256, averaged_weights=0.99, hidden=(64, 64), learning_rate=2e-3)
_SHORT_S, _LONG_S, _REST_S = 3.0, 60.0, 30.0
_LAST_LEVEL = 3.5


def _ablations() -> tuple[Contender, ...]:
    """Batched Q(λ), whose targets take the value of the best action, not of the chosen one."""
    if "greedy" not in get_args(TdTarget):
        return ()
    greedy = _reflex(target="greedy", averaged_weights=0.995)
    return (Contender("q-lambda-3s", "ablation", greedy, _SHORT_S),)


CONTENDERS = (
    Contender("reflex", "ours", Ours(PRESETS["reflex"]), _SHORT_S, is_paced=False),
    Contender("reflex-short", "ours", _QUICK, _SHORT_S, is_paced=False),
    Contender("reflex-3s", "ours", _reflex(averaged_weights=0.995), _SHORT_S),
    Contender("reflex-60s", "ours", _LONG, _LONG_S),
    Contender("reflex-deep-60s", "ours", _DEEP, _LONG_S),
    Contender("online-3s", "ours", Ours(PRESETS["reflex-online"]), _SHORT_S, cores=1),
    *_ablations(),
    Contender("ppo-tuned-short", "tuned", _PPO_SHORT, _SHORT_S),
    Contender("dqn-tuned-short", "tuned", _DQN_SHORT, _SHORT_S),
    Contender("ppo-tuned", "tuned", _PPO, _LONG_S),
    Contender("dqn-tuned", "tuned", _DQN, _LONG_S),
    Contender("qrdqn-tuned", "tuned", _QRDQN, _LONG_S),
    Contender("ppo-default", "default", Theirs("PPO"), _REST_S, stops_at=_LAST_LEVEL),
    Contender("dqn-default", "default", Theirs("DQN"), _REST_S, stops_at=_LAST_LEVEL),
    Contender("qrdqn-default", "default", Theirs("QRDQN"), _REST_S, stops_at=_LAST_LEVEL),
    Contender("ppo-matched", "matched", _with_hidden(_PPO, 10), _REST_S, stops_at=_LAST_LEVEL),
    Contender("dqn-matched", "matched", _with_hidden(_DQN, 10), _REST_S, stops_at=_LAST_LEVEL),
    Contender("qrdqn-matched", "matched", _with_hidden(_QRDQN, 10), _REST_S, stops_at=_LAST_LEVEL),
)

COLD = ("reflex-short", "online-3s", "ppo-tuned-short", "ppo-default")
"""Names of the contenders that also run cold."""
