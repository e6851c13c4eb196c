"""Where a run learns: worlds one after another, each for its share of the steps.

A world is kept as the text of its file, so that a run, its hash and its policy say exactly which
world it was, whatever becomes of the file.
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
        WorldError: no text is given, and there is no such world or file.
    """

    name: str = "reference-1"
    """Name of a world, or path of its file."""
    share: float = 1.0
    """Share of the steps that are learned from here, relative to the other worlds' shares."""
    text: str = ""
    """Its TOML, which may have ranges; by default what the name stands for now."""

    def __post_init__(self) -> None:
        require(0.0 < self.share < math.inf, "worlds: share", "positive", self.share)
        if not self.text:
            object.__setattr__(self, "text", world_text(self.name))

    def source(self) -> WorldSource:
        """The world.

        Raises:
            WorldError: the text says what no world can be.
        """
        return _parsed(self.text, self.name)


def parse_training_world(words: str) -> TrainingWorld:
    """Read NAME or NAME:SHARE; a name may be the path of a file.

    Raises:
        UsageError: the share is no number, or not positive.
        WorldError: there is no such world or file.
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
    """Where each world's part of a run of that length ends; the last one's is infinite."""
    total, done = math.fsum(world.share for world in worlds), 0.0
    ends = []
    for world in worlds[:-1]:
        done += world.share
        ends.append(length * done / total)
    return [*ends, math.inf]


def stage_at(ends: Sequence[float], done: float) -> int:
    """Which world is learned in after `done` of the run."""
    return next(stage for stage, end in enumerate(ends) if done < end)


@lru_cache(maxsize=32)
def _parsed(text: str, name: str) -> WorldSource:
    return parse_world(text, name)
