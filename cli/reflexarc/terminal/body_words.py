"""A body in words: its outline, when it obeys and how hard it brakes."""

from typing import NamedTuple

from reflexarc_runtime.contract.body_spec import Footprint


class BodyWords(NamedTuple):
    """The three things that a guard or a policy takes for granted about a body."""

    outline: str
    obeys: str
    stops: str


def body_words(footprint: Footprint, delay_s: float, braking_mps2: float | None) -> BodyWords:
    """A body for people.

    Args:
        footprint: its outline.
        delay_s: from a command's arrival to the motion.
        braking_mps2: how hard it brakes; None: it stops at once.
    """
    return BodyWords(
        _outline(footprint),
        f"after {delay_s:g} s" if delay_s else "at once",
        "at once" if braking_mps2 is None else f"at {braking_mps2:g} m/s²",
    )


def _outline(footprint: Footprint) -> str:
    if footprint.radius_m:
        return f"a circle of {footprint.radius_m:g} m"
    if not footprint.reach_m:
        return "a point"
    return (
        f"a rectangle: {footprint.ahead_m:g} m ahead, {footprint.behind_m:g} m behind, "
        f"{footprint.half_width_m:g} m to each side"
    )
