"""Worlds as tables: what compiled code is given of them.

One row a world (a single one, unless its numbers are drawn for each seed), one a layer, one a
shape.
"""

import math
from collections.abc import Sequence

import numpy as np

from reflexarc_runtime.contract import PolicyContract
from reflexarc_runtime.errors import WorldError
from reflexarc_sim_bridge.arrays.eyes import seen_behind_m, turns
from reflexarc_sim_bridge.arrays.layout import (
    AUTOMATON,
    BOX,
    CORRIDOR,
    CURVE,
    DISC,
    DRIFT,
    GATES,
    LAYER_DTYPE,
    OPEN,
    PERIODIC,
    PLANE_DTYPE,
    POLYGON,
    SCATTER,
    SHAPE_DTYPE,
    SWING,
    TURNED_BOX,
    UNBOUNDED,
    Table,
    WorldTables,
)
from reflexarc_sim_bridge.arrays.poisson import cumulative_counts, poisson_quantile
from reflexarc_sim_bridge.worlds.layers import (
    CHUNK_M,
    MAX_SECTIONS,
    Automaton,
    Corridor,
    Drift,
    Gates,
    Layer,
    Scatter,
    Swing,
    chunks_across,
)
from reflexarc_sim_bridge.worlds.shapes import Curves, Discs, Polygons, Rectangles, Shape
from reflexarc_sim_bridge.worlds.world import AfterContact, Edges, World


def world_tables(
    worlds: Sequence[World], contract: PolicyContract, fullest: Sequence[World] = ()
) -> WorldTables:
    """Worlds of one structure for the agents that a contract describes.

    Args:
        worlds: one for all agents, or one for each.
        contract: what the agents see and do.
        fullest: of all worlds that may take a row later one of these at least needs as much room;
            by default, of no others.

    Raises:
        WorldError: the worlds differ in their layers or shapes.
    """
    forms = {tuple(_shape_count(layer) for layer in world.layers) for world in worlds}
    if len(forms) != 1:
        raise WorldError("worlds: expected the same layers in every world of a family, got others")
    layers, shapes = max(1, len(worlds[0].layers)), max((*forms.pop(), 1))
    all_worlds = (*worlds, *fullest)
    tables = WorldTables(
        np.zeros(len(worlds), PLANE_DTYPE),
        np.zeros((len(worlds), layers), LAYER_DTYPE),
        np.zeros((len(worlds), layers, shapes), SHAPE_DTYPE),
        np.ones((len(worlds), layers, MAX_SECTIONS, _most_counts(all_worlds))),
        np.array([_most_belt_columns(n, fullest or worlds, contract) for n in range(layers)]),
        max(_across(world) for world in all_worlds),
    )
    for w, world in enumerate(worlds):
        write_world(tables, w, world, contract)
    return tables


def write_world(tables: WorldTables, w: int, world: World, contract: PolicyContract) -> None:
    """Fill row `w` of the tables."""
    _write_plane(tables.planes[w : w + 1], world, contract)
    for number, layer in enumerate(world.layers):
        row = tables.layers[w, number : number + 1]
        # With open edges an obstacle may lie beside its chunk, pushed inwards.
        row["reach_m"] = layer.reach_m * (2 if world.edges is Edges.OPEN else 1)
        _write_colour(row, layer)
        _write_motion(row, layer)
        match layer:
            case Scatter():
                _write_scatter(row, layer)
                _write_shapes(tables.shapes[w, number], layer.shapes)
                chunk_m2 = CHUNK_M * chunk_width_m(world)
                row["has_belt"] = 0 < _belt_columns(layer, world, contract) <= tables.belts[number]
                most = tables.counts.shape[3]
                tables.counts[w, number] = cumulative_counts(layer, chunk_m2, most)
            case Gates():
                _write_gates(row, layer, world)
            case Corridor():
                _write_corridor(row, layer)
            case Automaton():
                row["kind"], row["cells"] = AUTOMATON, layer.cells_per_chunk
                row["fill"], row["smoothings"] = layer.fill, layer.smoothings


def chunk_width_m(world: World) -> float:
    """Side of a chunk across the world."""
    return CHUNK_M if world.edges is Edges.UNBOUNDED else world.width_m / _across(world)


def _across(world: World) -> int:
    return 0 if world.edges is Edges.UNBOUNDED else chunks_across(world.width_m)


def _write_plane(row: Table, world: World, contract: PolicyContract) -> None:
    chassis, senses = world.chassis, world.senses
    aside_m = _aside_m(contract, world)
    row["dt_s"], row["width_m"], row["chunk_width_m"] = (
        world.dt_s,
        world.width_m,
        chunk_width_m(world),
    )
    row["reach_m"] = world.reach_m
    row["ahead_m"], row["aside_m"] = aside_m, aside_m
    row["behind_m"] = _behind_m(contract, world)
    row["radius_m"], row["slip"] = chassis.radius_m, chassis.slip
    row["follow"] = -math.expm1(-world.dt_s / chassis.lag_s) if chassis.lag_s > 0.0 else 1.0
    row["most_linear_mps"] = chassis.acceleration_mps2 * world.dt_s
    row["most_angular_radps"] = chassis.turn_acceleration_radps2 * world.dt_s
    row["noise"], row["dropout"] = senses.noise, senses.dropout
    row["background"], row["latency_steps"] = senses.background, senses.latency_steps
    row["edges"] = (PERIODIC, UNBOUNDED, OPEN)[
        (Edges.PERIODIC, Edges.UNBOUNDED, Edges.OPEN).index(world.edges)
    ]
    row["across"], row["stream"], row["layers"] = _across(world), world.stream, len(world.layers)
    row["corridor"] = world.layers.index(world.corridor) if world.corridor else -1
    row["after_contact"] = list(AfterContact).index(chassis.after_contact)


def _aside_m(contract: PolicyContract, world: World) -> float:
    """How far from an agent's cell anything can be seen or met."""
    return max(_range_m(contract), _step_m(contract, world))


def _behind_m(contract: PolicyContract, world: World) -> float:
    seen_m = _range_m(contract) if turns(contract) else seen_behind_m(contract.retina)
    return max(seen_m, _step_m(contract, world))


def _range_m(contract: PolicyContract) -> float:
    return contract.retina.range_m + contract.retina.baseline_m / 2


def _step_m(contract: PolicyContract, world: World) -> float:
    """How far a body reaches within a step, slipping as much as six standard deviations."""
    slipping = 1 + 6 * world.chassis.slip
    return _fastest_mps(contract, world) * world.dt_s * slipping + world.chassis.radius_m


def _write_colour(row: Table, layer: Layer) -> None:
    spans = layer.colour * 3 if len(layer.colour) == 1 else layer.colour
    row["channels"] = len(layer.colour)
    row["is_white"] = _is_white(layer)
    for name, (low, high) in zip(("red", "green", "blue"), spans, strict=True):
        row[f"{name}_low"], row[f"{name}_high"] = low, high


def _write_motion(row: Table, layer: Layer) -> None:
    match layer.motion:
        case Drift(ahead_mps, left_mps):
            row["motion"], row["moves_ahead"], row["moves_left"] = DRIFT, ahead_mps, left_mps
        case Swing(ahead_m, left_m, period_s):
            row["motion"], row["moves_ahead"], row["moves_left"] = SWING, ahead_m, left_m
            row["period_s"] = period_s


def _write_scatter(row: Table, layer: Scatter) -> None:
    row["kind"], row["shapes"], row["gap_m"] = SCATTER, len(layer.shapes), layer.gap_m
    only = layer.shapes[0]
    upright = isinstance(only, Discs) or (isinstance(only, Rectangles) and not only.is_turned)
    row["is_plain"] = len(layer.shapes) == 1 and upright
    row["sections"] = max(1, len(layer.sections))
    row["section_chunks"] = max(1, round(layer.section_m / CHUNK_M))


def _has_belt(layer: Layer, world: World, contract: PolicyContract) -> bool:
    """Nothing but white boxes of one kind, none of them farther than half a period when near."""
    if not isinstance(layer, Scatter) or world.edges is not Edges.PERIODIC:
        return False
    boxes = len(layer.shapes) == 1 and isinstance(layer.shapes[0], Rectangles)
    even = layer.gap_m == 0.0 and not layer.sections
    farthest_m = chunk_width_m(world) + _aside_m(contract, world) + layer.reach_m
    return boxes and even and _is_white(layer) and farthest_m <= 0.5 * world.width_m


def _belt_columns(layer: Layer, world: World, contract: PolicyContract) -> int:
    """Columns of chunks that a belt may have; 0 where there is none."""
    if not _has_belt(layer, world, contract):
        return 0
    beyond_m = _aside_m(contract, world) + _behind_m(contract, world) + 2 * layer.reach_m
    return math.ceil((CHUNK_M + beyond_m) / CHUNK_M) + 1


def _most_belt_columns(number: int, worlds: Sequence[World], contract: PolicyContract) -> int:
    """Most that the belts of a layer have; where it has none in the fullest worlds, none has."""
    layered = [world for world in worlds if number < len(world.layers)]
    return max((_belt_columns(w.layers[number], w, contract) for w in layered), default=0)


def _is_white(layer: Layer) -> bool:
    return all(span == (1.0, 1.0) for span in layer.colour)


def _write_gates(row: Table, layer: Gates, world: World) -> None:
    row["kind"], row["spacing_chunks"] = GATES, max(1, round(layer.spacing_m / CHUNK_M))
    row["pitch_m"] = world.pitch_m(layer)
    row["opening_low_m"], row["opening_high_m"] = layer.opening_m
    row["half_thickness_m"] = layer.thickness_m / 2


def _write_corridor(row: Table, layer: Corridor) -> None:
    row["kind"], row["half_width_m"] = CORRIDOR, layer.width_m / 2
    row["meander_m"], row["knot_m"] = layer.meander_m, layer.wavelength_m / 2


def _write_shapes(rows: Table, shapes: Sequence[Shape]) -> None:
    total, up_to = math.fsum(shape.share for shape in shapes), 0.0
    for number, shape in enumerate(shapes):
        row = rows[number : number + 1]
        up_to += shape.share / total
        row["share_up_to"] = up_to
        match shape:
            case Rectangles():
                row["kind"] = TURNED_BOX if shape.is_turned else BOX
                row["size_low"], row["size_high"] = shape.width_m
                row["length_low"], row["length_high"] = shape.length_m
                row["turned_low"], row["turned_high"] = shape.turned_rad
            case Discs():
                row["kind"] = DISC
                row["size_low"], row["size_high"] = shape.radius_m
            case Polygons():
                row["kind"] = POLYGON
                row["size_low"], row["size_high"] = shape.radius_m
                row["turned_high"] = math.tau
                row["dent_low"], row["dent_high"] = shape.dent
                row["corners_low"], row["corners_high"] = shape.corners
            case Curves():
                row["kind"] = CURVE
                row["size_low"], row["size_high"] = shape.radius_m
                row["turned_high"] = math.tau
                row["dent_low"], row["dent_high"] = shape.waviness


def _most_counts(worlds: Sequence[World]) -> int:
    """Most obstacles that a chunk of any of the worlds can have."""
    means = [
        layer.density_per_m2 * max(layer.sections or (1.0,)) * CHUNK_M * chunk_width_m(world)
        for world in worlds
        for layer in world.layers
        if isinstance(layer, Scatter)
    ]
    return max((poisson_quantile(mean) for mean in means), default=1)


def _shape_count(layer: Layer) -> int:
    return len(layer.shapes) if isinstance(layer, Scatter) else 0


def _fastest_mps(contract: PolicyContract, world: World) -> float:
    own = max(math.hypot(a.linear_mps, a.lateral_mps) for a in contract.actions)
    return own + max((_layer_speed_mps(layer) for layer in world.layers), default=0.0)


def _layer_speed_mps(layer: Layer) -> float:
    match layer.motion:
        case Drift(ahead_mps, left_mps):
            return math.hypot(ahead_mps, left_mps)
        case Swing(ahead_m, left_m, period_s):
            return math.tau / period_s * math.hypot(ahead_m, left_m)
    return 0.0
