"""Which of the scenario families of obstacle avoidance a world belongs to; many mix several.

F9 to F11 are not about the obstacles but about the agent. F13, real buildings from
lidar logs, is no world that could be driven in.
"""

from collections.abc import Iterator
from enum import StrEnum

from reflexarc_sim_bridge.worlds.layers import WHITE, Automaton, Corridor, Gates, Layer, Scatter
from reflexarc_sim_bridge.worlds.shapes import Discs, Rectangles
from reflexarc_sim_bridge.worlds.world import Chassis, Senses, World


class Scenario(StrEnum):
    """A family of scenarios."""

    DISCS = "F1 discs"
    RECTANGLES = "F2 rectangles"
    OUTLINES = "F3 turned boxes, polygons and curves"
    GATES = "F4 gates"
    CORRIDORS = "F5 corridors"
    STEPS = "F6 density steps"
    MOTION = "F7 moving obstacles"
    APPEARANCE = "F8 appearance"
    SENSES = "F9 senses"
    TIMING = "F10 timing"
    BODY = "F11 body"
    AUTOMATA = "F12 cellular automata"


def scenarios(world: World) -> tuple[Scenario, ...]:
    """The families of a world, in their order."""
    found = {scenario for layer in world.layers for scenario in _of_layer(layer)}
    found |= set(_of_agent(world))
    return tuple(scenario for scenario in Scenario if scenario in found)


def _of_layer(layer: Layer) -> Iterator[Scenario]:
    match layer:
        case Scatter():
            yield from map(_of_shape, layer.shapes)
            if layer.sections:
                yield Scenario.STEPS
        case Gates():
            yield Scenario.GATES
        case Corridor():
            yield Scenario.CORRIDORS
        case Automaton():
            yield Scenario.AUTOMATA
    if layer.motion is not None:
        yield Scenario.MOTION
    if layer.colour != WHITE:
        yield Scenario.APPEARANCE


def _of_shape(shape: object) -> Scenario:
    if isinstance(shape, Discs):
        return Scenario.DISCS
    is_upright = isinstance(shape, Rectangles) and not shape.is_turned
    return Scenario.RECTANGLES if is_upright else Scenario.OUTLINES


def _of_agent(world: World) -> Iterator[Scenario]:
    senses = world.senses
    if senses.background > 0.0:
        yield Scenario.APPEARANCE
    timeless = Senses(
        background=senses.background,
        latency_s=senses.latency_s,
        gap_s=senses.gap_s,
    )
    if senses != timeless or world.scanner is not None:
        yield Scenario.SENSES
    if world.latency_steps or world.gap_steps > 1:
        yield Scenario.TIMING
    if world.chassis != Chassis():
        yield Scenario.BODY
