"""Scenes laid out by hand: obstacles written into what an agent of an empty world keeps near."""

import math

import numpy as np

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_sim_bridge.arrays.layout import BOXES, DISCS, SIDES, TURNED
from reflexarc_sim_bridge.simulation.scene import Outline
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.layers import Motion, Scatter
from reflexarc_sim_bridge.worlds.shapes import Discs, Polygons, Rectangles
from reflexarc_sim_bridge.worlds.world import Chassis, Edges, Scanner, Senses, World

STANDS_AT_M = (1.25, 1.0)
"""Where the agent of a scene is: within its cell, whose corner is the origin of the world."""

_KINDS = (
    Rectangles(share=0.25),
    Rectangles(share=0.25, turned_rad=(0.0, 3.0)),
    Discs(share=0.25),
    Polygons(share=0.25, corners=(3, 32)),
)


def scene_of(
    outlines: list[Outline],
    contract: PolicyContract,
    *,
    heading_rad: float = 0.0,
    steps: int = 0,
    motion: Motion | None = None,
    chassis: Chassis | None = None,
    senses: Senses | None = None,
    scanner: Scanner | None = None,
    dt_s: float = 0.1,
) -> Simulation:
    """One agent at `STANDS_AT_M` among some obstacles, for one look or one step.

    With a motion the outlines are where the obstacles are at time 0.
    """
    layer = Scatter(density_per_m2=0.0, shapes=_KINDS, motion=motion)
    world = World(
        "scene",
        edges=Edges.UNBOUNDED,
        layers=(layer,),
        chassis=chassis or Chassis(),
        senses=senses or Senses(),
        scanner=scanner,
        dt_s=dt_s,
    )
    simulation = Simulation(world, contract, np.zeros(1, np.uint64))
    state = simulation.params.agents.state
    state["cell_x"], state["cell_y"], state["steps"] = 0, 0, steps
    state["x_m"], state["y_m"] = STANDS_AT_M
    state["heading_rad"] = heading_rad
    simulation.params.agents.layer_cells[:] = 0
    lay_out(simulation, outlines)
    return simulation


def lay_out(simulation: Simulation, outlines: list[Outline]) -> None:
    """Write obstacles into the first layer's lists of the first agent."""
    agents = simulation.params.agents
    counts = agents.near_counts[0, 0]
    columns = [(*box_rows(outline), outline) for outline in outlines if outline.is_box]
    boxes = [(rows, outline) for rows, turned, outline in columns if turned == (1.0, 0.0)]
    turned_boxes = [column for column in columns if column[1] != (1.0, 0.0)]
    discs = [outline for outline in outlines if outline.is_disc]
    counts[BOXES], counts[TURNED], counts[DISCS] = len(boxes), len(turned_boxes), len(discs)
    for k, (rows, outline) in enumerate(boxes):
        agents.boxes[0, 0, :, k] = (*rows, paint(outline))
    for k, (rows, turned, outline) in enumerate(turned_boxes):
        agents.turned[0, 0, :, k] = (*rows, paint(outline), *turned)
    for k, outline in enumerate(discs):
        agents.discs[0, 0, :, k] = (outline.x_m, outline.y_m, outline.radius_m, paint(outline))
    side = 0
    for outline in outlines:
        if outline.is_box or outline.is_disc:
            continue
        corners_m = outline.corners_m.astype(np.float32)
        edges_m = np.roll(corners_m, -1, axis=0) - corners_m
        for corner_m, edge_m in zip(corners_m, edges_m, strict=True):
            agents.sides[0, 0, :, side] = (*corner_m, *edge_m, paint(outline))
            side += 1
    counts[SIDES] = side


def box_rows(outline: Outline) -> tuple[tuple[float, ...], tuple[float, float]]:
    """Middle and half sides of a box, and cosine and sine of its angle, from its corners."""
    x_m, y_m = outline.corners_m.mean(axis=0).tolist()
    left_rear, right_rear = outline.corners_m[1:3]
    along, across = outline.corners_m[0] - left_rear, left_rear - right_rear
    half_length_m, half_width_m = math.hypot(*along) / 2, math.hypot(*across) / 2
    cos, sin = (along / (2 * half_length_m)).tolist()
    return (x_m, y_m, half_length_m, half_width_m), (cos, sin)


def paint(outline: Outline) -> int:
    red, green, blue = (round(255 * share) for share in outline.colour)
    return red << 16 | green << 8 | blue


def see_only_within(
    simulation: Simulation, range_m: float
) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    """Which rays of the first agent's eyes meet something nearer than that: (eyes, rays).

    So a distance can be asked for more finely than the 8 bits of a retina say it.
    """
    params = simulation.params
    simulation.params = params._replace(
        eye=params.eye._replace(range_m=float(range_m), nearness=False)
    )
    seen = simulation.sense()[0, :, :, 0] > 0
    simulation.params = params
    return seen
