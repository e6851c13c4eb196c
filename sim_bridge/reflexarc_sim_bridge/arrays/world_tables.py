"""Worlds as tables that compiled code reads.

One row a world (a single one, unless its numbers are drawn for each seed), one a layer, one a
shape.
"""

import math
from collections.abc import Sequence

import numpy as np

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import WorldError
from reflexarc_sim_bridge.arrays.eyes import seen_behind_m, turns
from reflexarc_sim_bridge.arrays.layout import (
    DRIFT,
    OPEN,
    PERIODIC,
    PLANE_DTYPE,
    SHAPE_DTYPE,
    SWING,
    UNBOUNDED,
    Row,
    Table,
    WorldTables,
    layer_dtype,
)
from reflexarc_sim_bridge.arrays.poisson import cumulative_counts, poisson_quantile
from reflexarc_sim_bridge.arrays.shape_table import write_shapes
from reflexarc_sim_bridge.worlds.grid import CHUNK_M, Across, Around
from reflexarc_sim_bridge.worlds.kinds.scatter import MAX_SECTIONS
from reflexarc_sim_bridge.worlds.layers import (
    Drift,
    Layer,
    Scatter,
    Swing,
    kind_number,
    layer_kinds,
)
from reflexarc_sim_bridge.worlds.shapes import Rectangles
from reflexarc_sim_bridge.worlds.world import AfterContact, Edges, World

WIDEST_BELT_M = 500.0
"""A belt holds a whole period, and putting an agent into a world draws all of it. Around wider ones
the few chunks near an agent are drawn instead: the widest world, 10 km, took minutes."""


def world_tables(
    worlds: Sequence[World],
    contract: PolicyContract,
    fullest: Sequence[World] = (),
    *,
    all_round: bool = False,
) -> WorldTables:
    """Worlds of one structure for the agents that a contract describes.

    Args:
        worlds: one for all agents, or one for each.
        contract: what the agents see and do.
        fullest: the worlds that need most memory of all that may take a row later; none by
            default: no other world ever takes a row.
        all_round: whether what lies behind an agent counts as near even if no eye looks there.

    Raises:
        WorldError: the worlds differ in their layers or shapes.
    """
    forms = {tuple(map(_form, world.layers)) for world in worlds}
    if len(forms) != 1:
        raise WorldError("worlds: expected the same layers in every world of a family, got others")
    layers = max(1, len(worlds[0].layers))
    shapes = max((count for _, count in forms.pop()), default=1)
    all_worlds = (*worlds, *fullest)
    tables = WorldTables(
        np.zeros(len(worlds), PLANE_DTYPE),
        np.zeros((len(worlds), layers), layer_dtype(layer_kinds())),
        np.zeros((len(worlds), layers, shapes), SHAPE_DTYPE),
        np.ones((len(worlds), layers, MAX_SECTIONS, _most_counts(all_worlds))),
        np.array(
            [_most_belt_columns(n, fullest or worlds, contract, all_round) for n in range(layers)]
        ),
        max(world.chunks_across for world in all_worlds),
    )
    for w, world in enumerate(worlds):
        write_world(tables, w, world, contract, all_round=all_round)
    return tables


def write_world(
    tables: WorldTables, w: int, world: World, contract: PolicyContract, *, all_round: bool = False
) -> None:
    """Fill row `w` of the tables; arguments as of `world_tables`."""
    plane = tables.planes[w : w + 1]
    _write_plane(plane, world, contract, all_round)
    for number, layer in enumerate(world.layers):
        row = tables.layers[w, number : number + 1]
        _write_layer(row, plane, layer, world)
        if isinstance(layer, Scatter):
            write_shapes(tables.shapes[w, number], layer.shapes)
            chunk_m2, most = CHUNK_M * world.chunk_width_m, tables.counts.shape[3]
            means = [density * chunk_m2 for density in layer.section_densities_per_m2]
            tables.counts[w, number] = cumulative_counts(means, most)
            columns = _belt_columns(layer, world, contract, all_round)
            row["has_belt"] = 0 < columns <= tables.belts[number]


def _write_plane(row: Table, world: World, contract: PolicyContract, all_round: bool) -> None:
    chassis, senses = world.chassis, world.senses
    aside_m = _aside_m(contract, world)
    row["dt_s"], row["width_m"], row["chunk_width_m"] = (
        world.dt_s,
        world.width_m,
        world.chunk_width_m,
    )
    row["reach_m"] = world.reach_m
    row["ahead_m"], row["aside_m"] = aside_m, aside_m
    row["behind_m"] = _behind_m(contract, world, all_round)
    row["radius_m"], row["slip"] = chassis.radius_m, world.slip_per_step
    row["follow"] = -math.expm1(-world.dt_s / chassis.lag_s) if chassis.lag_s > 0.0 else 1.0
    row["most_linear_mps"] = chassis.acceleration_mps2 * world.dt_s
    row["most_angular_radps"] = chassis.turn_acceleration_radps2 * world.dt_s
    row["noise"], row["dropout"] = senses.noise, senses.dropout
    row["background"], row["latency_steps"] = senses.background, world.latency_steps
    row["gap_steps"] = world.gap_steps
    row["edges"] = (PERIODIC, UNBOUNDED, OPEN)[
        (Edges.PERIODIC, Edges.UNBOUNDED, Edges.OPEN).index(world.edges)
    ]
    row["across"], row["stream"], row["layers"] = (
        world.chunks_across,
        world.stream,
        len(world.layers),
    )
    row["corridor"] = world.layers.index(world.corridor) if world.corridor else -1
    row["after_contact"] = list(AfterContact).index(chassis.after_contact)


def _aside_m(contract: PolicyContract, world: World) -> float:
    """How far from an agent's cell an obstacle can be seen or met."""
    return max(_range_m(contract), _step_m(contract, world))


def _behind_m(contract: PolicyContract, world: World, all_round: bool) -> float:
    is_around = all_round or turns(contract)
    seen_m = _range_m(contract) if is_around else seen_behind_m(contract.retina, world)
    return max(seen_m, _step_m(contract, world))


def _range_m(contract: PolicyContract) -> float:
    return contract.retina.range_m + contract.retina.baseline_m / 2


def _step_m(contract: PolicyContract, world: World) -> float:
    """How far a body reaches within a step, slipping as much as six standard deviations."""
    slipping = 1 + 6 * world.slip_per_step
    return _fastest_mps(contract, world) * world.dt_s * slipping + world.chassis.radius_m


def _write_layer(row: Table, plane: Table, layer: Layer, world: World) -> None:
    """Fill the columns that all layers have, then those of the layer's kind."""
    row["kind"] = kind_number(layer)
    # With open edges an obstacle may lie beside its chunk, pushed inwards.
    row["reach_m"] = layer.reach_m * (2 if world.edges is Edges.OPEN else 1)
    _write_colour(row, layer)
    _write_motion(row, layer)
    columns = layer.columns(Across(world.chunk_width_m, world.period_m))
    for name, value in columns._asdict().items():
        row[name] = value
    for name, most in layer.most_near(_around(plane[0], row[0]))._asdict().items():
        row[f"most_{name}"] = most


def _around(plane: Row, layer: Row) -> Around:
    """The part of a layer that may be near an agent."""
    reach_m = 2 * layer["reach_m"]
    return Around(
        length_m=CHUNK_M + plane["ahead_m"] + plane["behind_m"] + reach_m,
        width_m=plane["chunk_width_m"] + 2 * plane["aside_m"] + reach_m,
        chunk_width_m=plane["chunk_width_m"],
        crowding=_crowding(plane, layer),
    )


def _crowding(plane: Row, layer: Row) -> float:
    """How much denser centres lie than they are drawn: with open edges, pushed inwards.

    They are more than four times as dense only in a strip that is narrower than the box around an
    agent. Where it is just that wide, widths within a family's range may have 5 % more of them than
    its ends.
    """
    if plane["edges"] != OPEN:
        return 1.0
    room_m = plane["width_m"] - layer["reach_m"]
    return float(plane["width_m"] / max(room_m, plane["width_m"] / 4))


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


def _has_belt(layer: Layer, world: World, contract: PolicyContract) -> bool:
    """Whether it is nothing but white boxes of one kind, near ones within half a period."""
    if not isinstance(layer, Scatter) or world.edges is not Edges.PERIODIC:
        return False
    if world.width_m > WIDEST_BELT_M:
        return False
    boxes = len(layer.shapes) == 1 and isinstance(layer.shapes[0], Rectangles)
    even = layer.gap_m == 0.0 and not layer.sections
    farthest_m = world.chunk_width_m + _aside_m(contract, world) + layer.reach_m
    return boxes and even and _is_white(layer) and farthest_m <= 0.5 * world.width_m


def _belt_columns(layer: Layer, world: World, contract: PolicyContract, all_round: bool) -> int:
    """Columns of chunks that a belt may have; 0 where there is none."""
    if not _has_belt(layer, world, contract):
        return 0
    behind_m = _behind_m(contract, world, all_round)
    beyond_m = _aside_m(contract, world) + behind_m + 2 * layer.reach_m
    return math.ceil((CHUNK_M + beyond_m) / CHUNK_M) + 1


def _most_belt_columns(
    number: int, worlds: Sequence[World], contract: PolicyContract, all_round: bool
) -> int:
    """Most columns of chunks of a layer's belts; 0 if it has no belt in any of the worlds."""
    layered = [world for world in worlds if number < len(world.layers)]
    columns = (_belt_columns(w.layers[number], w, contract, all_round) for w in layered)
    return max(columns, default=0)


def _is_white(layer: Layer) -> bool:
    return all(span == (1.0, 1.0) for span in layer.colour)


def _most_counts(worlds: Sequence[World]) -> int:
    """Most obstacles that a chunk of any of the worlds can have."""
    means = [
        max(layer.section_densities_per_m2) * CHUNK_M * world.chunk_width_m
        for world in worlds
        for layer in world.layers
        if isinstance(layer, Scatter)
    ]
    return max((poisson_quantile(mean) for mean in means), default=1)


def _form(layer: Layer) -> tuple[type[Layer], int]:
    """Its kind, and how many rows of shapes it has: at least one."""
    return type(layer), len(layer.shapes) if isinstance(layer, Scatter) else 1


def _fastest_mps(contract: PolicyContract, world: World) -> float:
    motions_of_body = (*contract.actions, contract.safe_command)  # a stop may creep
    own = max(math.hypot(a.linear_mps, a.lateral_mps) for a in motions_of_body)
    motions = [layer.motion for layer in world.layers if layer.motion is not None]
    return own + max((motion.fastest_mps for motion in motions), default=0.0)
