"""At which rate and with which body a contender drives through a cell.

`robot` is what it will do on a robot: the rate, the footprint, the delay and the brakes of its
contract. `field` is the same for all: a point that obeys at once and decides ten times a second, as
on the reference field. Speeds, eye, hold and margin are the contract's in both.
"""

import math
from dataclasses import replace
from enum import StrEnum
from functools import partial

from reflexarc_runtime.contract.body_spec import BodySpec
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.evaluation.protocol.contender import Contender
from reflexarc_sim_bridge.worlds.changed import changed
from reflexarc_sim_bridge.worlds.layers import WHITE, Corridor, Layer, Scatter
from reflexarc_sim_bridge.worlds.world import World, WorldSource

FIELD_RATE_HZ = 10.0


class Setting(StrEnum):
    """Rate and body."""

    ROBOT = "robot"
    """Those of the contract; where it names no body, a point."""
    FIELD = "field"
    """Ten decisions a second, a point."""

    def rate_hz(self, contract: PolicyContract) -> float:
        """Decisions, and looks, a second."""
        return contract.rate_hz if self is Setting.ROBOT else FIELD_RATE_HZ

    def body(self, contract: PolicyContract) -> BodySpec | None:
        """The body; None: what each world says."""
        named = contract.body if contract.body != BodySpec() else None
        return named if self is Setting.ROBOT else None


def worlds_for(source: WorldSource, contender: Contender, setting: Setting) -> WorldSource:
    """The worlds of a cell, at a contender's rate, with its body, as its senses show them.

    Raises:
        UsageError: its footprint is a rectangle, which the simulator does not have.
    """
    contract = contender.contract
    body = setting.body(contract)
    if body is not None and body.footprint.half_width_m:
        raise UsageError(f"{contender.name}: expected a round body, got a rectangle")
    return as_driven(source, setting.rate_hz(contract), body, contender.sees_ranges)


def as_driven(
    source: WorldSource, rate_hz: float, body: BodySpec | None, sees_ranges: bool
) -> WorldSource:
    """Worlds at a rate, with a body, as senses show them.

    Args:
        source: the world, or family of worlds.
        rate_hz: looks, and decisions, a second.
        body: the body; None: each world's own.
        sees_ranges: whether colours play no part.
    """
    change = partial(_as_driven, rate_hz=rate_hz, body=body, sees_ranges=sees_ranges)
    return changed(source, change)


def _as_driven(world: World, rate_hz: float, body: BodySpec | None, sees_ranges: bool) -> World:
    world = replace(world, dt_s=1.0 / rate_hz)
    if body is not None:
        world = with_body(world, body)
    return without_colours(world) if sees_ranges else world


def with_body(world: World, body: BodySpec) -> World:
    """A world for a body. What a world itself makes worse, its slip and its delay, it keeps.

    The body follows commands with a lag of first order whose time constant is its delay: after a
    stop it goes on as far as a body that obeys after that delay.
    """
    braking = body.deceleration_mps2
    own = world.chassis
    chassis = replace(
        own,
        radius_m=body.footprint.radius_m,
        lag_s=max(own.lag_s, body.actuation_delay_s),
        acceleration_mps2=min(own.acceleration_mps2, math.inf if braking is None else braking),
    )
    return replace(world, chassis=chassis)


def without_colours(world: World) -> World:
    """A world as a range finder sees it: all that is there is white, and nothing else is bright."""
    layers = tuple(map(_whitened, world.layers))
    return replace(world, layers=layers, senses=replace(world.senses, background=0.0))


def _whitened(layer: Layer) -> Layer:
    match layer:
        case Corridor():
            still = replace(layer, left_wall_mps=0.0, right_wall_mps=0.0)
            return replace(
                still, stripes_m=0.0, left_contrast=1.0, right_contrast=1.0, colour=WHITE
            )
        case Scatter():
            return replace(layer, stripes_m=0.0, colour=WHITE)
    return replace(layer, colour=WHITE)
