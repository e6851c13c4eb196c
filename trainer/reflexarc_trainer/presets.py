"""The named starting points of a run.

Figures in the help are contacts per 100 m on validation worlds of the reference field, seeds 0 to
19; `python benchmarks/learner.py --presets` measures the same on test worlds.
"""

from collections.abc import Mapping
from types import MappingProxyType

from reflexarc_runtime.contract import RetinaSpec, Shading
from reflexarc_runtime.errors import UsageError
from reflexarc_trainer.config import TrainConfig

PAPER_RANGE_M = 1.5
"""The paper says "the immediate proximity" only. On validation worlds, means of three or four seeds
in contacts per 100 m: 12.7 at 0.6 m, 9.1 at 0.8 m, 7.0 at 1 m, 6.6 at 1.25 m, 6.4 at 1.5 m, 6.2 at
1.75 m, 7.4 at 2 m, 13.3 at 3 m (0.6, 0.8, 2 and 3 m with linear outputs): flat around 1.5 m."""

LIDAR_RATE_HZ = 10.0
LIDAR_AGE_S = 0.3
"""A Hokuyo URG-04LX on a robot scans every 98 ms at the median and 140 ms at the 99th percentile
(the CoreSLAM log `exp2.dat`); three periods bridge two lost scans."""

PRESETS: Mapping[str, TrainConfig] = MappingProxyType(
    {
        "reflex": TrainConfig(preset="reflex"),
        "lidar": TrainConfig(
            preset="lidar", world="scanned", rate_hz=LIDAR_RATE_HZ, max_input_age_s=LIDAR_AGE_S
        ),
        "paper": TrainConfig(
            preset="paper", retina=RetinaSpec(range_m=PAPER_RANGE_M, shading=Shading.COLOUR)
        ),
    }
)

HELP: Mapping[str, str] = MappingProxyType(
    {
        "reflex": (
            "The default, for use: the paper's network and learner (16-10-3, alpha 0.5, lambda "
            "0.9, gamma 0.9) behind the eye of the reference field, whose rays grow brighter as "
            "things come nearer, up to 5 m. Reaches about 4 contacts per 100 m in 500,000 steps "
            "(3.0 to 5.2 over 20 seeds), where a blind agent has 36.0."
        ),
        "lidar": (
            "For range scanners, with `run --input scan`: learned on simulated scans of 181 beams "
            "over 180 degrees, from which each of the 16 rays takes the nearest beam, as the "
            "runtime does; 5 m, 10 Hz, and an input may be 0.3 s old."
        ),
        "paper": (
            "For comparison with the paper: the same network and learner behind its literal eye: "
            "a ray shows the colour of the first thing within the immediate proximity (1.5 m) "
            "and says nothing of its distance. Reaches about 6.4 contacts per 100 m in 500,000 "
            "steps (6.1 to 6.8 over 20 seeds), where a blind agent has 36.0. Two things are not "
            "in the paper: the bounded step, and what follows a contact."
        ),
    }
)
"""For each preset one paragraph: what it is for, what it reaches."""


def preset_named(name: str) -> TrainConfig:
    """The configuration of that name.

    Raises:
        UsageError: there is none.
    """
    if name not in PRESETS:
        raise UsageError(f"preset: no preset is named {name!r}; known: {', '.join(PRESETS)}")
    return PRESETS[name]
