"""The judge of a run: its clock, and the looks (measurements of the policy on validation worlds).

Looks come at times that grow by the same ratio for all contenders; the clock is stopped meanwhile.
A policy that has not changed since the last look is not measured again, so that two looks in a row
are of two different policies.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import pairwise

from learning_race.frozen import FrozenPolicy
from reflexarc_sim_bridge.evaluation.reference_field import measure
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from reflexarc_sim_bridge.worlds.seeds import validation_seeds

RATIO = 1.25
FIRST_LOOK_S = 0.01 / RATIO**7  # about 2 ms
AGENTS, STEPS, DISCARDED_STEPS = 256, 300, 50
"""As the trainer validates: `ValidationConfig`."""
LEVELS = (6.0, 4.5, 3.5)
"""Contacts per 100 m."""


@dataclass(frozen=True)
class Look:
    """A measurement of the policy."""

    seconds: float
    """Time of learning so far, without looks."""
    world_steps: int
    contacts_per_100m: float


class Clock:
    """A stopwatch of wall-clock time."""

    def __init__(self, started_s: float | None = None) -> None:
        """Start now, or at a time of `time.monotonic`, which may be another process's."""
        self._started_s = time.monotonic() if started_s is None else started_s

    @property
    def seconds(self) -> float:
        """Seconds since the start, without the time in which it was stopped."""
        return time.monotonic() - self._started_s

    @contextmanager
    def stopped(self) -> Iterator[None]:
        """A context in which the clock is stopped."""
        began_s = time.monotonic()
        yield
        self._started_s += time.monotonic() - began_s


@dataclass
class Judge:
    """Decides when to look and when a run ends; keeps the looks."""

    clock: Clock
    limit_s: float
    stops_at: float | None = None
    """The run ends when it reaches this level."""
    rate: Callable[[FrozenPolicy], float] = field(default=lambda policy: validation_rate(policy))
    looks: list[Look] = field(default_factory=list)
    due_s: float = FIRST_LOOK_S
    starts_cold: bool = False
    """Whether the times of looks grow from the first look on, as compilation came before it."""
    origin_s: float = 0.0
    """Time from which they grow."""
    last: FrozenPolicy | None = None
    ended_s: float = 0.0
    """Time of the last call of `look`, whether or not it measured."""

    @property
    def is_due(self) -> bool:
        """Whether it is time for a look."""
        return self.clock.seconds >= min(self.due_s, self.limit_s)

    @property
    def is_over(self) -> bool:
        """Whether the run has to end."""
        return self.clock.seconds >= self.limit_s or (
            self.stops_at is not None and reached(self.looks, self.stops_at) is not None
        )

    def look(self, frozen: Callable[[], FrozenPolicy], world_steps: int) -> None:
        """Measure the policy, with the clock stopped, if it has changed since the last look."""
        self.ended_s = seconds = self.clock.seconds
        with self.clock.stopped():
            self._put_off(seconds)
            policy = frozen()
            if self.last is None or not policy.equals(self.last):
                self.looks.append(Look(seconds, world_steps, self.rate(policy)))
            self.last = policy

    def _put_off(self, seconds: float) -> None:
        """Set the time of the next look."""
        if self.starts_cold and not self.looks:
            self.origin_s, self.due_s = seconds, seconds + FIRST_LOOK_S
        while self.due_s <= seconds:
            self.due_s = self.origin_s + (self.due_s - self.origin_s) * RATIO


def validation_rate(policy: FrozenPolicy) -> float:
    """Contacts per 100 m of a policy on validation worlds."""
    score = measure(
        policy,
        reference_contract(),
        agents=AGENTS,
        steps=STEPS,
        discard=DISCARDED_STEPS,
        seeds=validation_seeds(AGENTS),
    )
    return score.contacts_per_100m


def reached(looks: list[Look], level: float) -> Look | None:
    """The first of two looks in a row that pass a level; None if there are none."""
    for one, next_one in pairwise(looks):
        if max(one.contacts_per_100m, next_one.contacts_per_100m) <= level:
            return one
    return None
