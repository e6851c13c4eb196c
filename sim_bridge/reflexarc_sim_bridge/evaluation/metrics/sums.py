"""What a track adds up to, world by world: every figure is a function of such sums.

Sums of different worlds, agents and stretches can be added, so that it does not matter in how many
pieces a cell was driven. Most are one value a world; a histogram is a row of values a world.
"""

from collections.abc import Callable, Mapping
from types import MappingProxyType

from reflexarc_sim_bridge.evaluation.metrics import (
    clearances,
    collisions,
    farthest,
    lateral,
    smoothness,
    survival,
    switches,
    threats,
)
from reflexarc_sim_bridge.evaluation.metrics.track import Floats, Track

Sums = dict[str, Floats]
"""By the name of the sum: one value a world, or one row of them: (worlds, …)."""

PER_AGENT: Mapping[str, Callable[[Track], Floats]] = MappingProxyType(
    {
        each.__name__: each
        for each in (
            collisions.agents,
            collisions.contacts,
            collisions.progress_m,
            collisions.time_s,
            collisions.way_m,
            collisions.free_paths,
            survival.way_lives,
            survival.time_lives,
            threats.threats,
            threats.met_threats,
            threats.surprises,
            threats.threat_time_s,
            threats.soon_time_s,
            threats.least_ahead_s,
            threats.reactions,
            threats.reaction_m,
            threats.reaction_limits,
            clearances.clearance_steps,
            clearances.close_time_s,
            clearances.least_clearance,
            switches.switches,
            switches.reversals,
            switches.holds,
            switches.short_holds,
            switches.action_steps,
            smoothness.aside_m,
            smoothness.ahead_m,
            smoothness.turned_rad,
            smoothness.turned_way_m,
            smoothness.jerk,
            smoothness.jerk_time_s,
            lateral.edge_time_s,
            lateral.sided_time_s,
            lateral.place_steps,
            lateral.side_steps,
            farthest.farthest_m,
        )
    }
)
"""Each from a track to (agents, …); the name of the function is that of the sum."""


def sums_of(track: Track) -> Sums:
    """All sums of a track."""
    return {name: track.over_worlds(each(track)) for name, each in PER_AGENT.items()}
