"""Presets: complete configurations, by name, to start a run from.

Figures in the help are contacts per 100 m on test worlds. Those over 30 seeds were measured by
`reflexarc study thirty`, those of the presets for lidars by `python benchmarks/eyes.py`, the others
by `python benchmarks/learner.py --presets`.
"""

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

from reflexarc_runtime.contract.eye import Shading
from reflexarc_runtime.errors import UsageError
from reflexarc_trainer.config.train_config import (
    BatchedConfig,
    ExplorationConfig,
    LearnerConfig,
    NetworkConfig,
    OnlineConfig,
    TrainConfig,
    TrainingWorld,
    eye_of_today,
)

PAPER_RANGE_M = 1.5
"""Range of the paper's eye, for which the paper says only "the immediate proximity". On validation
worlds, means of three or four seeds
in contacts per 100 m: 12.7 at 0.6 m, 9.1 at 0.8 m, 7.0 at 1 m, 6.6 at 1.25 m, 6.4 at 1.5 m, 6.2 at
1.75 m, 7.4 at 2 m, 13.3 at 3 m (0.6, 0.8, 2 and 3 m with linear outputs): flat around 1.5 m."""

BASELINE_M = 0.1
"""Distance between the two eyes. Validation worlds, two seeds each, contacts per 100 m: 3.2 and 2.7
at 0.1 m, 3.7 and 3.3 at 0.3 m, 4.9 and 4.8 at 0.6 m."""

TURNING_RADPS = 2.0
"""Turning speed. Validation worlds of `rover`, two seeds each, contacts per 100 m of path: 1.1 and
1.1 at 1 rad/s, 0.4 and 0.5 at 2 rad/s, 1.6 and 0.5 at 3 rad/s, where the body also turns more than
twice as much as at 2 rad/s."""

LIDAR_RATE_HZ = 10.0
LIDAR_AGE_S = 0.3
"""A Hokuyo URG-04LX on a robot scans every 98 ms at the median and 140 ms at the 99th percentile
(the CoreSLAM log `exp2.dat`); three periods bridge two lost scans."""

SLOW_LIDAR_AGE_S = 0.4
"""Lidars that turn at 5.5 to 10 Hz (RPLIDAR A1, LD19): two of their longest periods, 182 ms, and
a tenth of jitter, so that one lost scan is bridged."""
SLOW_RECOVERY = 2
"""Good inputs before it drives again: 0.36 s of a scanner that turns at 5.5 Hz."""
ROVER_MPS = 0.5
"""Of small bodies on two wheels that carry such a lidar."""

_NETWORK = NetworkConfig(hidden=(64,), units="relu", output="linear", input_power=2)
_LEARNER = LearnerConfig(
    form="batched",
    trace_decay=0.5,
    gamma=0.9,
    averaged_weights=0.95,
    exploration=ExplorationConfig(epsilon_span=0.3, action_repeat=3),
    batched=BatchedConfig(agents=128, minibatches=16, learning_rate=5e-3),
)
"""Chosen on validation worlds, three seeds of 2^19 transitions each, contacts per 100 m: 2.3, 2.5
and 2.4; with four minibatches 2.8, 2.8 and 2.6; with two layers of 32 units 2.6, 2.5 and 2.7; with
one world step per transition, each action held for three transitions, λ 0.8: 2.6, 2.9 and 2.7. With
inputs that are not squared it learned half as well in earlier trials."""
_CALM = replace(
    _LEARNER, reward_switch=-0.05, exploration=replace(_LEARNER.exploration, least_lead=0.05)
)
"""Learns with a least lead, and pays for switches. Validation worlds at 50 Hz, seven seeds, with a
least lead of 0.06: 2.01 contacts per 100 m and 1.21 switches a second, `_LEARNER` 2.08 and 1.32;
without any 1.89 and 4.8, `_LEARNER` 1.93 and 6.4. A cost of 0.1: 2.02 and 1.31 (three seeds)."""
HOLD_S = 0.06
LEAST_LEAD = 0.04
"""How long an action is done at least, and what another one must be better by, in the unit of Q,
where a contact costs 1: the knee, of the settings with at most 5 % more contacts the one with the
fewest switches (docs/chatter.md). Presets for lidars of 10 Hz have none: they switch once a second
anyway, and 0.03 already costs a tenth more contacts. `rover` learns as before: its few contacts,
50 to 120 in three seeds, show no difference."""
_ONLINE_NETWORK = replace(_NETWORK, hidden=(63,))
"""63 units and one for the biases fill whole vector registers: see `weight_rows.py`."""
_ONLINE_LEARNER = LearnerConfig(
    trace_decay=0.6,
    gamma=0.95,
    averaged_weights=0.99995,
    reward_switch=_CALM.reward_switch,
    exploration=_CALM.exploration,
    online=OnlineConfig(step="rmsprop", alpha=5e-4, alpha_end=0.0, precision="float32"),
)
"""`benchmarks/learning_race/tuning.md` lists what else was tried."""
_PAPERS_EYE = replace(eye_of_today(), range_m=PAPER_RANGE_M, shading=Shading.COLOUR)
_STEPS = 1 << 19

_REFLEX = TrainConfig(
    preset="reflex",
    steps=_STEPS,
    hold_s=HOLD_S,
    least_lead=LEAST_LEAD,
    network=_NETWORK,
    learner=_CALM,
)
_LIDAR = TrainConfig(
    preset="lidar",
    steps=_STEPS,
    worlds=(TrainingWorld("site"),),
    rate_hz=LIDAR_RATE_HZ,
    max_input_age_s=LIDAR_AGE_S,
    network=_NETWORK,
    learner=_LEARNER,
)
_PAPER = TrainConfig(preset="paper", retina=_PAPERS_EYE)

_ALL = (
    _REFLEX,
    _LIDAR,
    replace(
        _LIDAR,
        preset="rover-lidar",
        motion="turning",
        forward_mps=ROVER_MPS,
        angular_radps=TURNING_RADPS,
        max_input_age_s=SLOW_LIDAR_AGE_S,
        recovery_inputs=SLOW_RECOVERY,
    ),
    replace(
        _REFLEX,
        preset="binocular",
        retina=replace(eye_of_today(), rays=8, eyes=2, baseline_m=BASELINE_M),
    ),
    replace(
        _REFLEX,
        preset="rover",
        worlds=(TrainingWorld("rover"),),
        motion="turning",
        angular_radps=TURNING_RADPS,
        learner=_LEARNER,
    ),
    replace(
        _REFLEX,
        preset="reflex-online",
        steps=1 << 20,
        network=_ONLINE_NETWORK,
        learner=_ONLINE_LEARNER,
    ),
    TrainConfig(preset="online"),
    _PAPER,
    replace(
        _PAPER,
        preset="paper-literal",
        network=NetworkConfig(output="linear"),
        learner=LearnerConfig(online=OnlineConfig(step="literal")),
    ),
)
PRESETS: Mapping[str, TrainConfig] = MappingProxyType({config.preset: config for config in _ALL})

HELP: Mapping[str, str] = MappingProxyType(
    {
        "reflex": (
            "The default, for use: the eye of the reference field, whose rays grow brighter as "
            "things come nearer, up to 5 m, a network 16-64-3 and 128 agents that learn together "
            "from lambda-returns (gamma 0.9, lambda 0.5), each action repeated for three steps. "
            "Keeps an action for 0.06 s, and until another is better by 0.04 in Q. Makes about 1.9 "
            "contacts per 100 m at 50 Hz (1.8 to 2.0, three seeds), with 1.2 switches a second, "
            "and 2.5 at the field's 10 Hz (2.5 to 2.6) after 520,000 transitions, where a blind "
            "agent has 36.0; with `--hold 0 --lead 0` 1.85 and 2.3, with 4.6 switches."
        ),
        "lidar": (
            "For range scanners of 10 Hz and more on a body that moves sideways, with `run --input "
            "scan`: each of 16 rays shows the nearest return of its sector of 180 degrees, 5 m; an "
            "input may be 0.3 s old. Learned in the world `site`, of posts, boxes and people, with "
            "a disc of 0.2 m that obeys after 0.1 s and brakes by 2 m/s2. With this body, ten "
            "seeds: 0.7 contacts per 100 m among posts of 10 cm (blind 20), 0.5 among boxes "
            "(blind 13), 1.1 among walkers (blind 8)."
        ),
        "rover-lidar": (
            "For wheels and the lidars that are sold with them, 5.5 to 10 Hz: left and right turn "
            "the body at 2 rad/s, at 0.5 m/s; an input may be 0.4 s old, and two good ones are "
            "enough to drive again. Eye, body and world of `lidar`. With this body, ten seeds: "
            "0.3 contacts per 100 m of path among posts of 10 cm (blind 20), 0.1 among boxes "
            "(blind 13), 4.1 among walkers (blind 11), who walk faster than it drives. It keeps "
            "clear and knows no direction."
        ),
        "binocular": (
            "Two eyes of 8 rays each, 0.1 m apart, in place of one of 16: as many values, fewer "
            "bearings, and near things stand at different ones for either eye. Learner and world "
            "of `reflex`, its hold and its least lead. Reaches about 2.3 contacts per 100 m at "
            "10 Hz in 520,000 transitions (2.2 to 2.3, three seeds); `reflexarc study eyes` "
            "compares more."
        ),
        "rover": (
            "For wheels: left and right turn the body at 2 rad/s, at a uniform 1 m/s, a disc of "
            "0.2 m with inertia in the world `rover`. Reaches about 0.3 contacts per 100 m of path "
            "in 520,000 transitions (0.21 to 0.34, four seeds), where a blind agent has 33. It "
            "keeps clear and knows no direction: on the whole it gets nowhere along x."
        ),
        "reflex-online": (
            "One agent and one update a step, as on a robot that learns while it drives, with "
            "what serves best: each action repeated for three steps, squared inputs, a step "
            "divided by each weight's running RMS, averaged weights, single precision. Network "
            "16-63-3, hold and least lead of `reflex`. Reaches 1.9 to 2.0 contacts per 100 m at "
            "10 Hz in a million transitions (test worlds, three seeds)."
        ),
        "online": (
            "One agent and one update a step: the paper's "
            "network and learner (16-10-3, alpha 0.5, lambda 0.9, gamma 0.9) behind the "
            "eye of the reference field. Reaches about 4 contacts per 100 m in 500,000 steps (3.1 "
            "to 5.7 over 30 seeds), where a blind agent has 36.0."
        ),
        "paper": (
            "For comparison with the paper: the same network and learner behind its literal eye: "
            "a ray shows the colour of the first thing within the immediate proximity (1.5 m) "
            "and says nothing of its distance. Reaches about 6.5 contacts per 100 m in 500,000 "
            "steps (6.1 to 7.5 over 30 seeds), where a blind agent has 36.0. Two things are not "
            "in the paper: the bounded step, and what follows a contact."
        ),
        "paper-literal": (
            "The paper's words taken literally, with outputs that can hold negative values: "
            "linear ones, and alpha = 0.5 as it is. It overshoots, its units saturate, and it "
            "learns nothing; where the weights grow without limit the run stops and says so."
        ),
    }
)
"""One paragraph per preset: its purpose, and what it reaches."""


def preset_named(name: str) -> TrainConfig:
    """The preset of a name.

    Raises:
        UsageError: no preset has this name.
    """
    if name not in PRESETS:
        raise UsageError(f"preset: no preset is named {name!r}; known: {', '.join(PRESETS)}")
    return PRESETS[name]
