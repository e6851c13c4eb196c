"""How fast a policy may drive with its eye and its body, and still stand before what it sees.

    way = v · (age of the input + period + validity of a command + delay) + v² / (2 · deceleration)

A thing that is seen for the first time at the end of the eye's range lies so far from the edge of
the body as the range is longer than the body reaches. In the worst case the last input that led to
a motion was as old as the contract allows, the loop decided a period later, and the command counts
for as long again as an input may be old: so long is a command valid.
"""

import math
from typing import TYPE_CHECKING

from reflexarc_runtime.errors import ContractError

if TYPE_CHECKING:  # a command line shall not load a contract to show its flags
    from reflexarc_runtime.contract.contract import PolicyContract

FLAG = "--allow-fast"


def delays_s(contract: "PolicyContract") -> float:
    """Longest time from what is seen to the motion that it ends: see the module's formula."""
    validity_s = contract.max_input_age_s
    period_s = 1.0 / contract.rate_hz
    return contract.max_input_age_s + period_s + validity_s + contract.body.actuation_delay_s


def stopping_way_m(speed_mps: float, late_s: float, deceleration_mps2: float | None) -> float:
    """How far a body goes until it stands.

    Args:
        speed_mps: of the body.
        late_s: time before it brakes.
        deceleration_mps2: how hard it brakes; None: at once.
    """
    braking_m = 0.0 if deceleration_mps2 is None else speed_mps**2 / (2.0 * deceleration_mps2)
    return speed_mps * late_s + braking_m


def largest_speed_mps(free_m: float, late_s: float, deceleration_mps2: float | None) -> float:
    """The speed at which a body stands after `free_m`: the inverse of `stopping_way_m`."""
    if free_m <= 0.0:
        return 0.0
    if deceleration_mps2 is None:
        return free_m / late_s
    braking = deceleration_mps2
    return braking * (math.sqrt(late_s**2 + 2.0 * free_m / braking) - late_s)


def why_too_fast(contract: "PolicyContract") -> str:
    """Why a policy cannot stand before what it sees, with the numbers; empty if it can."""
    speeds = [math.hypot(action.linear_mps, action.lateral_mps) for action in contract.actions]
    late_s, braking = delays_s(contract), contract.body.deceleration_mps2
    free_m = contract.retina.range_m - contract.body.footprint.reach_m
    most_mps = largest_speed_mps(free_m, late_s, braking)
    if max(speeds) <= most_mps:
        return ""
    brakes = "stops at once" if braking is None else f"brakes by {braking:g} m/s²"
    return (
        f"it drives {max(speeds):.3g} m/s and needs "
        f"{stopping_way_m(max(speeds), late_s, braking):.3g} m to stand ({late_s:.3g} s late, "
        f"{brakes}), but sees {free_m:.3g} m from its edge: expected at most {most_mps:.3g} m/s"
    )


def check_speed(contract: "PolicyContract", *, allow: bool = False) -> str:
    """Refuse a policy that is too fast for its eye and the body that it names.

    A contract that names no body, as older ones, cannot be judged so: what is then returned is to
    be said as a warning.

    Raises:
        ContractError: it is too fast, with the numbers.
    """
    why = why_too_fast(contract)
    if not why or allow:
        return ""
    if contract.body == type(contract.body)():
        return f"even if its body were a point that stops at once, {why}"
    raise ContractError(f"too fast for its eye: {why}; {FLAG} if it is meant so")
