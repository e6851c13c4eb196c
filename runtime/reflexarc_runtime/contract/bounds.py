"""What a contract may ask for at most before anything moves by it.

A policy file is input from outside. A robot that is meant to be faster, or to wait longer, says so
by flags of its own.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from reflexarc_runtime.errors import ContractError

if TYPE_CHECKING:  # the bounds are flags, and a command line shall not load a contract to show them
    from reflexarc_runtime.contract.contract import PolicyContract


@dataclass(frozen=True)
class Bounds:
    """The largest speeds and times that a contract may ask for."""

    max_speed_mps: float = 20.0
    """Largest linear and lateral speed that a policy may ask for, metres a second."""
    max_turn_radps: float = 20.0
    """Largest angular speed that a policy may ask for, radians a second."""
    max_wait_s: float = 2.0
    """Largest age of an input, delay and hold that a policy may ask for, seconds."""
    allow_moving_stop: bool = False
    """Accept a policy whose safe command is not standstill."""


def check_bounds(contract: "PolicyContract", bounds: Bounds) -> None:
    """Refuse a contract that asks for more than the bounds allow.

    Raises:
        ContractError: the first thing that is beyond them, and the flag that widens them.
    """
    for excess in excesses(contract, bounds):
        raise ContractError(excess)


def excesses(contract: "PolicyContract", bounds: Bounds) -> Iterator[str]:
    """Each thing that a contract asks for beyond the bounds, with the flag that widens them."""
    safe = contract.safe_command
    for action in (*contract.actions, safe):
        name, speed_mps = repr(action.name), bounds.max_speed_mps
        along, across = abs(action.linear_mps), abs(action.lateral_mps)
        yield from _beyond(f"{name} drives", along, speed_mps, "m/s", "--max-speed-mps")
        yield from _beyond(f"{name} moves sideways", across, speed_mps, "m/s", "--max-speed-mps")
        turn, most = abs(action.angular_radps), bounds.max_turn_radps
        yield from _beyond(f"{name} turns", turn, most, "rad/s", "--max-turn-radps")
    waits = {
        "inputs may be old": contract.max_input_age_s,
        "the body obeys after": contract.body.actuation_delay_s,
        "actions are held for": contract.hold_s,
    }
    for what, seconds in waits.items():
        yield from _beyond(what, seconds, bounds.max_wait_s, "s", "--max-wait-s")
    if not (safe.stands or bounds.allow_moving_stop):
        yield (
            f"safe_command: expected standstill, got {safe.linear_mps:g} m/s, "
            f"{safe.lateral_mps:g} m/s, {safe.angular_radps:g} rad/s; --allow-moving-stop if it is "
            "meant so"
        )


def _beyond(what: str, got: float, most: float, unit: str, flag: str) -> Iterator[str]:
    if math.isnan(most):
        yield f"{flag}: expected a number, got nan"
    elif not got <= most:
        yield f"{what}: expected at most {most:g} {unit}, got {got:g}; {flag} if it is meant so"
