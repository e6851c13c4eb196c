"""The named starting points of a run.

Figures in the help are contacts per 100 m on the reference field's test worlds, where an agent
that never steers scores 36.0; `python benchmarks/learner.py --presets` measures them.
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

PRESETS: Mapping[str, TrainConfig] = MappingProxyType(
    {
        "reflex": TrainConfig(preset="reflex"),
        "paper": TrainConfig(
            preset="paper", retina=RetinaSpec(range_m=PAPER_RANGE_M, shading=Shading.COLOUR)
        ),
    }
)

HELP: Mapping[str, str] = MappingProxyType({"reflex": "", "paper": ""})
"""For each preset one paragraph: what it is for, what it reaches."""


def preset_named(name: str) -> TrainConfig:
    """The configuration of that name.

    Raises:
        UsageError: there is none.
    """
    if name not in PRESETS:
        raise UsageError(f"preset: no preset is named {name!r}; known: {', '.join(PRESETS)}")
    return PRESETS[name]
