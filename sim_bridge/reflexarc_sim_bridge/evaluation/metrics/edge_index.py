"""The edge index: how much more time a policy spends at the sides of a track than elsewhere.

    E = (share of the time within 2R of a side) / (4R/W)

R is half the mean lateral width of an obstacle plus the agent's radius, W the width of the track.
An agent whose lateral places are uniform has E = 1; one that is always at the sides has W/4R. A
periodic world has no sides: the same bands are taken, as if its seam were a wall.
"""

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.worlds.layers import Scatter
from reflexarc_sim_bridge.worlds.world import Edges, World, WorldSource


def edge_index(
    lateral_m: npt.NDArray[np.float64], width_m: float, obstacle_radius_m: float
) -> float:
    """E of a set of lateral places.

    Args:
        lateral_m: places from the right side on, in [0, W]: any shape.
        width_m: W.
        obstacle_radius_m: R; 4R is less than W.
    """
    band_m = 2.0 * obstacle_radius_m
    near = (lateral_m < band_m) | (lateral_m > width_m - band_m)
    return float(near.mean() / (2.0 * band_m / width_m))


def obstacle_radius_m(world: World) -> float:
    """R: half the mean lateral width of the scattered obstacles, plus the agent's radius."""
    scatters = [layer for layer in world.layers if isinstance(layer, Scatter)]
    densities = [layer.mean_density_per_m2 for layer in scatters]
    widths = [layer.mean_width_m for layer in scatters]
    return float(np.average(widths, weights=densities)) / 2 + world.chassis.radius_m


def require_edge_index(world: WorldSource) -> World:
    """The world, if it has sides or a seam, and only scattered obstacles in between.

    Raises:
        UsageError: it has no sides, other obstacles, or too little width.
    """
    scattered = isinstance(world, World) and all(isinstance(part, Scatter) for part in world.layers)
    if not (isinstance(world, World) and scattered and world.layers):
        raise UsageError(f"{world.name}: expected one world of scattered obstacles, for its edges")
    too_wide = 4.0 * obstacle_radius_m(world) >= world.width_m
    if world.edges is Edges.UNBOUNDED or too_wide:
        raise UsageError(f"{world.name}: expected a width of more than 4R, for its edges")
    return world
