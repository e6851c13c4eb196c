"""A world, or every world of a family, with something changed: its body, its rate, its senses."""

from collections.abc import Callable
from dataclasses import dataclass

from reflexarc_sim_bridge.worlds.world import World, WorldSource

Change = Callable[[World], World]


@dataclass(frozen=True)
class ChangedWorlds:
    """A family of worlds, each of them changed alike."""

    source: WorldSource
    change: Change

    @property
    def name(self) -> str:
        """See `WorldSource.name`."""
        return self.source.name

    @property
    def description(self) -> str:
        """See `WorldSource.description`."""
        return self.source.description

    @property
    def blind_contacts_per_100m(self) -> float | None:
        """See `WorldSource.blind_contacts_per_100m`: unknown, as for every family."""
        return None

    @property
    def fullest(self) -> tuple[World, ...]:
        """See `WorldSource.fullest`."""
        return tuple(map(self.change, self.source.fullest))

    def drawn(self, seed: int) -> World:
        """See `WorldSource.drawn`."""
        return self.change(self.source.drawn(seed))


def changed(source: WorldSource, change: Change) -> WorldSource:
    """One world changed, or a family of changed ones.

    Args:
        source: the world, or family of worlds.
        change: from a world to another; must do the same each time.
    """
    return change(source) if isinstance(source, World) else ChangedWorlds(source, change)
