"""The clock of a run, and what it stops for: a look at the frozen policy on validation worlds.

Looks come at times that grow by the same ratio for everybody. A look at a policy that has learned
nothing since the last one is no look: two in a row are two policies.
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
    """What was seen."""

    seconds: float
    """Of learning, looks left out."""
    world_steps: int
    contacts_per_100m: float


class Clock:
    """Wall-clock seconds since `started_s`, pauses left out."""

    def __init__(self, started_s: float | None = None) -> None:
        """Start, or have been started at that time of `time.monotonic`, in another process even."""
        self._started_s = time.monotonic() if started_s is None else started_s

    @property
    def seconds(self) -> float:
        """So far."""
        return time.monotonic() - self._started_s

    @contextmanager
    def stopped(self) -> Iterator[None]:
        """Within it no time passes."""
        began_s = time.monotonic()
        yield
        self._started_s += time.monotonic() - began_s


@dataclass
class Judge:
    """Says when to look and when to stop, and remembers what it saw."""

    clock: Clock
    limit_s: float
    stops_at: float | None = None
    """The run may end where this level is reached."""
    rate: Callable[[FrozenPolicy], float] = field(default=lambda policy: validation_rate(policy))
    looks: list[Look] = field(default_factory=list)
    due_s: float = FIRST_LOOK_S
    starts_cold: bool = False
    """Whether the times of looks grow from the first one on: what came before was compiling."""
    origin_s: float = 0.0
    """From where they grow."""
    last: FrozenPolicy | None = None
    ended_s: float = 0.0
    """When it was last asked to look, though nothing may have been learned since."""

    @property
    def is_due(self) -> bool:
        """Whether it is time for a look."""
        return self.clock.seconds >= min(self.due_s, self.limit_s)

    @property
    def is_over(self) -> bool:
        """Whether the run has to stop."""
        return self.clock.seconds >= self.limit_s or (
            self.stops_at is not None and reached(self.looks, self.stops_at) is not None
        )

    def look(self, frozen: Callable[[], FrozenPolicy], world_steps: int) -> None:
        """Measure the policy, unless it is the last one still; the clock stands meanwhile."""
        self.ended_s = seconds = self.clock.seconds
        with self.clock.stopped():
            self._put_off(seconds)
            policy = frozen()
            if self.last is None or not policy.equals(self.last):
                self.looks.append(Look(seconds, world_steps, self.rate(policy)))
            self.last = policy

    def _put_off(self, seconds: float) -> None:
        """Be due at the next of the growing times."""
        if self.starts_cold and not self.looks:
            self.origin_s, self.due_s = seconds, seconds + FIRST_LOOK_S
        while self.due_s <= seconds:
            self.due_s = self.origin_s + (self.due_s - self.origin_s) * RATIO


def validation_rate(policy: FrozenPolicy) -> float:
    """Contacts per 100 m on validation worlds."""
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
    """The first of two looks in a row that pass a level, if there are such."""
    for one, next_one in pairwise(looks):
        if max(one.contacts_per_100m, next_one.contacts_per_100m) <= level:
            return one
    return None
