"""Training worlds with the body and the sensor that a policy will have.

A body is a disc. It follows its commands with a lag of first order, whose time constant is the
delay: after a stop it goes on as far as a body that obeys after that delay. Its linear speeds
change by no more in a second than it brakes. A sensor sends a new retina after 1 to n steps, drawn
evenly each time, where n steps are the largest age of an input: as late and as seldom as the
runtime accepts it.
"""

import math
from dataclasses import replace
from functools import partial

from reflexarc_runtime.contract.body_spec import BodySpec
from reflexarc_sim_bridge.worlds.changed import changed
from reflexarc_sim_bridge.worlds.world import World, WorldSource


def embodied(source: WorldSource, body: BodySpec | None, max_input_age_s: float) -> WorldSource:
    """Worlds with a body, and with a sensor as slow as inputs may be old.

    Args:
        source: the world, or family of worlds.
        body: the body; None: each world's own.
        max_input_age_s: largest age of an input.
    """
    return changed(source, partial(with_body, body=body, max_input_age_s=max_input_age_s))


def with_body(world: World, body: BodySpec | None, max_input_age_s: float) -> World:
    """One world with a body and a sensor: see `embodied`."""
    gap_s = max(world.senses.gap_s, max_input_age_s)
    slower = replace(world, senses=replace(world.senses, gap_s=gap_s))
    # A sensor that sends at every step anyway stays what it is, whatever an input may be old.
    world = slower if slower.gap_steps > world.gap_steps else world
    if body is None:
        return world
    braking = body.deceleration_mps2
    chassis = replace(
        world.chassis,
        radius_m=body.footprint.radius_m,
        lag_s=body.actuation_delay_s,
        acceleration_mps2=math.inf if braking is None else braking,
    )
    return replace(world, chassis=chassis)
