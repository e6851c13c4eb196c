"""The named starting points of a run.

Figures in the help are contacts per 100 m on the reference field's test worlds, where an agent
that never steers scores 36.0; `python benchmarks/presets.py` measures them.
"""

from collections.abc import Mapping
from types import MappingProxyType

from reflexarc_runtime.contract import RetinaSpec, Shading
from reflexarc_runtime.errors import UsageError
from reflexarc_trainer.config import TrainConfig

PAPER_RANGE_M = 1.5
"""The paper says "the immediate proximity" only; chosen on validation worlds among 0.6 to 3 m."""

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
