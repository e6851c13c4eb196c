"""A world with more or less in it: its scattered obstacles at a wanted clutter number.

Clutter is ρR²v/w (Karaman and Frazzoli, arXiv 1202.0253), here for v = w and a point: ρ obstacles a
square metre, R half their mean lateral width. At a given clutter all densities are scaled alike.
"""

import math
from dataclasses import replace

from reflexarc_runtime.errors import WorldError
from reflexarc_sim_bridge.worlds.layers import Layer, Scatter
from reflexarc_sim_bridge.worlds.world import World, WorldSource


def at_clutter(source: WorldSource, clutter: float) -> World:
    """The world, thinned or thickened.

    Args:
        source: one world of scattered obstacles, none of them thinned by a gap.
        clutter: ρR² for a point.

    Raises:
        WorldError: a family of worlds, one without scattered obstacles, or with a gap; or so many
            that they would cover more than a world may have covered.
    """
    if not isinstance(source, World):
        raise WorldError(f"{source.name}: expected one world for a degree of clutter, got a family")
    scatters = [layer for layer in source.layers if isinstance(layer, Scatter)]
    if not scatters or any(layer.gap_m for layer in scatters):
        raise WorldError(f"{source.name}: expected scattered obstacles without a gap")
    factor = clutter / _as_point(source).clutter()
    layers = tuple(_scaled(layer, factor) for layer in source.layers)
    return replace(source, name=f"{source.name} at {clutter:.2f}", layers=layers)


def free_path_m(world: World) -> float | None:
    """Mean free path 1 / 2ρR of a body that never steers; None where nothing is scattered."""
    widths_m = [
        layer.mean_density_per_m2 * (layer.mean_width_m + 2.0 * world.chassis.radius_m)
        for layer in world.layers
        if isinstance(layer, Scatter)
    ]
    met_per_m = math.fsum(widths_m)
    return 1.0 / met_per_m if met_per_m > 0.0 else None


def _as_point(world: World) -> World:
    return replace(world, chassis=replace(world.chassis, radius_m=0.0))


def _scaled(layer: Layer, factor: float) -> Layer:
    if not isinstance(layer, Scatter):
        return layer
    return replace(layer, density_per_m2=layer.density_per_m2 * factor)
