"""The worlds of a run, one after another, each for its share of the steps (a curriculum).

A configuration holds the text of each world's file, so that the configuration and its hash define
the run even if the file changes later. Each world's part of the run is called a stage.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from reflexarc_runtime.config.checks import require
from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.worlds.files import parse_world, world_text
from reflexarc_sim_bridge.worlds.world import WorldSource


@dataclass(frozen=True)
class TrainingWorld:
    """A world to learn in, and for how much of the run.

    Raises:
        WorldError: no text is given, and no world or file has this name.
    """

    name: str = "reference-1"
    """Name of a world, or path of its file."""
    share: float = 1.0
    """Share of the run's steps in this world, relative to the shares of the others."""
    text: str = ""
    """Content of the world's TOML file, which may have ranges; by default read by the name."""

    def __post_init__(self) -> None:
        require(0.0 < self.share < math.inf, "worlds: share", "positive", self.share)
        if not self.text:
            object.__setattr__(self, "text", world_text(self.name))

    def source(self) -> WorldSource:
        """The world, as the simulation takes it.

        Raises:
            WorldError: the text does not describe a possible world.
        """
        return _parsed(self.text, self.name)


def parse_training_world(words: str) -> TrainingWorld:
    """Read NAME or NAME:SHARE; a name may be the path of a file.

    Raises:
        UsageError: the share is not a positive number.
        WorldError: no world or file has this name.
    """
    name, colon, share = words.rpartition(":")
    if not colon:
        return TrainingWorld(words)
    try:
        return TrainingWorld(name, float(share))
    except ValueError:
        wanted = "NAME or NAME:SHARE, as in tier-10:0.5"
        raise UsageError(f"worlds: expected {wanted}, got {words!r}") from None


def stage_ends(worlds: Sequence[TrainingWorld], length: float) -> list[float]:
    """Where each stage of a run ends; the last one does not.

    Args:
        worlds: of the run.
        length: of the run, in any unit.

    Returns:
        One end per world in the same unit, the last one infinite.
    """
    total, done = math.fsum(world.share for world in worlds), 0.0
    ends = []
    for world in worlds[:-1]:
        done += world.share
        ends.append(length * done / total)
    return [*ends, math.inf]


def stage_at(ends: Sequence[float], done: float) -> int:
    """Number of the stage after `done` of the run, which is in the unit of `ends`."""
    return next(stage for stage, end in enumerate(ends) if done < end)


@lru_cache(maxsize=32)
def _parsed(text: str, name: str) -> WorldSource:
    return parse_world(text, name)
