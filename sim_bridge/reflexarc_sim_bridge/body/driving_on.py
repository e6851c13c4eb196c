"""From a moment of a ride on: where it leads, and whether it touches anything."""

import math
from collections import Counter
from dataclasses import dataclass

from reflexarc_runtime.decision import ASKED
from reflexarc_sim_bridge.body.body import BodyPose
from reflexarc_sim_bridge.body.ride import Ride


@dataclass(frozen=True)
class DrivenWay:
    """What was driven from a moment on."""

    places: tuple[BodyPose, ...]
    """Where it was after each step without a contact; the first is where it began."""
    contact_step: int | None
    """The step, from 0, that ended in a contact, behind which nothing was driven; None: none."""
    nearest_m: float
    """Least room around the body at any of the places; the eye's range if nothing was nearer."""
    driven_m: float
    not_asked: dict[str, int]
    """Decisions without the policy, by verdict: what stands touches little."""


def drive_on(ride: Ride, from_ns: int, steps: int) -> DrivenWay:
    """Drive, up to the first contact.

    Args:
        ride: at the moment from which it drives; the body has not looked there yet.
        from_ns: the time of that moment, on the body's clock.
        steps: how many at most.
    """
    step_ns = round(ride.body.info.step_s * 1e9)
    places, nearest_m = [ride.body.place], ride.clearance_m
    driven_m, not_asked = 0.0, Counter[str]()
    before_m = float(ride.body.simulation.distance_m[0])
    for step in range(steps):
        now_ns = from_ns + step * step_ns
        decision = ride.look(now_ns)
        if decision is not None and decision.verdict not in ASKED:
            not_asked[decision.verdict.name] += 1
        if ride.obey(now_ns) is not None:
            return DrivenWay(tuple(places), step, 0.0, driven_m, dict(not_asked))
        nearest_m = min(nearest_m, ride.clearance_m)
        after_m = float(ride.body.simulation.distance_m[0])
        sideways_m = ride.body.place.y_m - places[-1].y_m
        driven_m += math.hypot(after_m - before_m, _within_half(sideways_m, ride))
        places.append(ride.body.place)
        before_m = after_m
    return DrivenWay(tuple(places), None, nearest_m, driven_m, dict(not_asked))


def _within_half(sideways_m: float, ride: Ride) -> float:
    """A step sideways, across the seam of a periodic world as well."""
    plane = ride.body.simulation.params.world.planes[0]
    return math.remainder(sideways_m, float(plane["width_m"]))
