"""A moment of a drive: one contact, the seconds before it, and the command that drives it again."""

from dataclasses import dataclass

from reflexarc_pictures.courses.course import Course
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting


@dataclass(frozen=True)
class Moment:
    """One contact of a contender in a cell of a suite."""

    contender: str
    setting: Setting
    family: str
    tier: str
    world: str
    seed: int
    """Of the world."""
    lane: int
    """Which of the agents in it."""
    step: int
    """That ended in the contact, from the agent's start."""
    at_s: float
    """When that step ended."""
    warning_s: float | None
    """For how long what it met had been straight ahead of it; None: not known."""
    course: Course
    """The seconds before; its last snapshot is the one after the contact."""
    command: str
    """Draws it again."""
