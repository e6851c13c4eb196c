"""The guard: a check that has learned nothing, between what a policy wants and what is done.

It asks one question of the ranges that the robot has measured: is the ground free that the body
sweeps until it could stand again?

    way = speed · (age of the ranges + validity of a command + delay) + speed² / (2 · deceleration)

The outline of the body, widened by a margin, goes that way along the path of the commanded motion.
Where nothing was measured, nothing is free: a beam that says nothing counts as something very near,
and no motion leads out of the sector that is seen. If the wanted action is not free, the policy's
next-best one that is takes its place; then a slower motion; then standstill. An action whose way is
free for somewhat longer is preferred: the wanted one, if it is, else the next best.

Pure, and the same for one robot and for many simulated ones. What it cannot see it cannot guard:
things thinner than the gap between two beams, things that move, and, in a retina, things darker
than the brightest: a ray's value tells how far away its thing is at most.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.beams import Beams, Fan
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.inertia import Order, is_same, path, touches
from reflexarc_runtime.reach import Reaches, reaches_m
from reflexarc_runtime.sweep import Floats, Speeds, swept_speed_mps, touch_times_s

SHARES = (1.0, 0.75, 0.5, 0.25)
"""Shares of a speed that the guard allows. A few steps, so that a robot, a replay on another
machine and a simulated crowd come to the same one; less than the last is standstill."""

VERY_NEAR_M = 1e-6
"""Where a beam that says nothing, or less than its sensor can measure, sees something."""
VERY_FAR_M = 1e6
"""Where a beam ends that meets nothing: infinity has no place."""


AGE_STEPS = 8
"""Into how many steps the age of ranges is divided, up to the oldest that a command may rest on:
what is surely free for the end of a step is free for all of it."""


_HAIR_S = 1e-9


@dataclass(frozen=True, slots=True)
class Answer:
    """What the guard lets a body do."""

    action: int | None
    """Index of the action; None: stand."""
    share: float
    """How much of its speed."""


STAND = Answer(None, 0.0)


@dataclass(frozen=True)
class Guard:
    """The settings, and what a contract adds: its actions, and how long a command holds."""

    settings: GuardSettings
    actions: tuple[Action, ...]
    valid_for_s: float

    @classmethod
    def for_contract(cls, settings: GuardSettings, contract: PolicyContract) -> Self:
        """The guard of a policy's actions."""
        return cls(settings, contract.actions, contract.max_input_age_s)

    def answer(
        self,
        wanted: int,
        q_values: Sequence[float],
        beams: Beams | None,
        age_s: float,
        moving: Speeds | None = None,
    ) -> Answer:
        """What is done at this tick.

        Args:
            wanted: the action that the policy, a hold or a margin chose.
            q_values: of all actions.
            beams: what was measured last; None: nothing was.
            age_s: how old that is.
            moving: how the body moves now; None: as it will be told.
        """
        if beams is None:
            return STAND
        if self._is_surely_free(wanted, beams, age_s) and self._gets_there(
            self._twists[wanted], beams, age_s, moving, in_time=True
        ):
            return self._as_wanted[wanted]
        late_s, touched_s = age_s + self.settings.evade_s, dict[int, float]()
        for action in in_order(wanted, q_values):
            twist = self._twists[action]
            way = self._way(twist, late_s)
            if action == wanted or not self._is_surely_free(action, beams, age_s):
                touched_s[action] = self._touch_s(twist, beams, way.limit_m)
            else:
                touched_s[action] = math.inf
            is_free = _share(twist, beams.fan, way, touched_s[action]) == 1.0
            if is_free and self._gets_there(twist, beams, age_s, moving, in_time=True):
                return self._as_wanted[action]
        return self._least_evil(touched_s, beams, age_s, moving)

    def prepare(self, fan: Fan) -> None:
        """Work out beforehand what checks along these beams will use."""
        self._reaches.prepare(fan, len(self.actions))

    def _is_surely_free(self, action: int, beams: Beams, age_s: float) -> bool:
        """Whether an action is free in good time, as far as one comparison tells.

        True only where the geometry finds the same; mostly, where it does.
        """
        steps = age_s * self._steps_per_s
        if not steps < AGE_STEPS:
            return False
        reaches = self._reaches.of(beams.fan, action)
        if reaches is None:
            return False
        # `all`, in a third of its time: a byte for each beam, 0 where it is too near or no number.
        return 0 not in (beams.ranges_m >= reaches[int(steps)]).tobytes()

    def _work_out(self, fan: Fan, action: int) -> Floats:
        """How far along each beam an action may touch something, for each step of age."""
        twist, mine = self._twists[action], self.settings
        ages_s = [step / self._steps_per_s + mine.evade_s for step in range(AGE_STEPS + 1)]
        ways_s = [self._way(twist, age_s).full_s for age_s in ages_s]
        ends_s = [way_s + _HAIR_S for way_s in ways_s[1:]]
        reaches = reaches_m(fan, mine.footprint, mine.margin_m, twist, ends_s)
        for step, end_s in enumerate(ends_s):
            if not _surely_in_sight(fan, twist, ways_s[step] - _HAIR_S, end_s):
                reaches[step] = math.nan
        return reaches

    def _least_evil(
        self, touched_s: dict[int, float], beams: Beams, age_s: float, moving: Speeds | None
    ) -> Answer:
        """Where nothing is free in good time: what is free now, or free when it goes slower.

        Args:
            touched_s: when each action touches something, in the order in which they are tried.
            beams: what was measured.
            age_s: how long ago.
            moving: how the body moves now.
        """
        best = STAND
        for action, time_s in touched_s.items():
            twist = self._twists[action]
            share = _share(twist, beams.fan, self._way(twist, age_s), time_s)
            share = self._reached(share, twist, beams, age_s, moving)
            if share == 1.0:
                return Answer(action, share)
            if self.settings.may_slow and share > best.share:
                best = Answer(action, share)
        return best

    def share(
        self, twist: Speeds, beams: Beams, age_s: float, moving: Speeds | None = None
    ) -> float:
        """The largest of `SHARES` at which a motion's way is free; 0.0: none."""
        way = self._way(twist, age_s)
        share = _share(twist, beams.fan, way, self._touch_s(twist, beams, way.limit_m))
        return self._reached(share, twist, beams, age_s, moving)

    def _reached(
        self, share: float, twist: Speeds, beams: Beams, age_s: float, moving: Speeds | None
    ) -> float:
        """The largest share, up to this one, that the body comes to without touching anything."""
        for less in SHARES:
            slower = less * twist[0], less * twist[1], less * twist[2]
            if less <= share and self._gets_there(slower, beams, age_s, moving):
                return less
        return 0.0

    def _gets_there(
        self,
        twist: Speeds,
        beams: Beams,
        age_s: float,
        moving: Speeds | None,
        *,
        in_time: bool = False,
    ) -> bool:
        """Whether the path from the body's motion to another one is free as well.

        A body that does already what it is told goes the straight way, which is looked at anyhow.
        """
        mine = self.settings
        braking = mine.follows_mps2
        if moving is None or braking is None or is_same(moving, twist):
            return True
        held_s = self.valid_for_s + (mine.evade_s if in_time else 0.0)
        places = path(moving, Order(twist, age_s + mine.delay_s, held_s), braking)
        limit_m = self._outline_m + float(np.abs(places[:, :2]).max()) * math.sqrt(2.0) + 0.1
        near = (~(beams.ranges_m >= limit_m)).nonzero()[0]
        if not len(near):
            return True
        known_m = _known_m(beams.ranges_m[near])
        x_m, y_m = known_m * beams.fan.cos[near], known_m * beams.fan.sin[near]
        return not touches(x_m, y_m, mine.footprint, mine.margin_m, places)

    def _touch_s(self, twist: Speeds, beams: Beams, limit_m: float) -> float:
        """When a motion touches the first thing that is nearer than a limit; +inf: never."""
        near = (~(beams.ranges_m >= limit_m)).nonzero()[0]  # what is no number is near
        if not len(near):
            return math.inf
        ranges_m, fan = beams.ranges_m[near], beams.fan
        return float(self._touched_s(ranges_m, fan.cos[near], fan.sin[near], twist))

    def shares(self, beams: Beams, age_s: float) -> Floats:
        """`share` for many agents at once: of each action, (agents, actions)."""
        columns = [self._column(twist, beams, age_s) for twist in self._twists]
        return np.stack(columns, axis=-1)

    def _column(self, twist: Speeds, beams: Beams, age_s: float) -> Floats:
        way, ranges_m, fan = self._way(twist, age_s), beams.ranges_m, beams.fan
        allowed = np.zeros(ranges_m.shape[:-1])
        if not _stays_in_sight(fan, twist, way.full_s):
            return allowed
        rows = np.flatnonzero(~(ranges_m.min(axis=-1) >= way.limit_m))  # NaN is the minimum, too
        allowed[:] = 1.0
        touched_s = self._touched_s(ranges_m[rows], fan.cos, fan.sin, twist)
        allowed[rows] = 0.0
        for share in reversed(SHARES):
            allowed[rows[way.at_share_s(share) <= touched_s]] = share
        return allowed

    def _touched_s(self, ranges_m: Floats, cos: Floats, sin: Floats, twist: Speeds) -> Floats:
        """When the first of the beams' points is touched: of (…, beams), (…)."""
        known_m, mine = _known_m(ranges_m), self.settings
        times_s = touch_times_s(known_m * cos, known_m * sin, mine.footprint, mine.margin_m, twist)
        first_s: Floats = np.minimum.reduce(times_s, axis=-1)
        return first_s

    def _way(self, twist: Speeds, age_s: float) -> "GroundNeeded":
        mine, outline_m = self.settings, self._outline_m
        speed_mps = swept_speed_mps(mine.footprint, twist)
        braking = mine.deceleration_mps2
        braking_s = 0.0 if braking is None else speed_mps / (2.0 * braking)
        obeyed_s = age_s + self.valid_for_s + mine.delay_s
        limit_m = outline_m + speed_mps * (obeyed_s + braking_s) if any(twist) else 0.0
        return GroundNeeded(obeyed_s, braking_s, limit_m)

    @cached_property
    def _outline_m(self) -> float:
        """No point of the widened outline is farther from the origin."""
        return self.settings.footprint.reach_m + math.sqrt(2.0) * self.settings.margin_m

    @cached_property
    def _reaches(self) -> Reaches:
        return Reaches(self._work_out)

    @cached_property
    def _steps_per_s(self) -> float:
        own_s = self.settings.ranges_oldest_s if self.settings.ranges else 0.0
        return AGE_STEPS / max(self.valid_for_s, own_s, _HAIR_S)

    @cached_property
    def _as_wanted(self) -> tuple[Answer, ...]:
        return tuple(Answer(action, 1.0) for action in range(len(self.actions)))

    @cached_property
    def _twists(self) -> tuple[Speeds, ...]:
        return tuple((a.linear_mps, a.lateral_mps, a.angular_radps) for a in self.actions)


@dataclass(frozen=True, slots=True)
class GroundNeeded:
    """How much ground a motion needs, in seconds at its full speed."""

    obeyed_s: float
    """For so long it goes on at least."""
    braking_s: float
    """Its way of braking at full speed, which is as the square of the speed."""
    limit_m: float
    """What is farther from the origin is not touched."""

    @property
    def full_s(self) -> float:
        """At full speed."""
        return self.obeyed_s + self.braking_s

    def at_share_s(self, share: float) -> float:
        """At a share of the speed."""
        return share * self.obeyed_s + share * share * self.braking_s


def _known_m(ranges_m: Floats) -> Floats:
    """Where each beam ends: what was not measured is very near."""
    known_m: Floats = np.fmax(np.minimum(ranges_m, VERY_FAR_M), VERY_NEAR_M)  # so is NaN
    return known_m


def asks_the_input(guard: Guard | None) -> bool:
    """Whether there is a guard, and it has its ranges from what the policy sees."""
    return guard is not None and not guard.settings.ranges


def in_order(wanted: int, q_values: Sequence[float]) -> Iterator[int]:
    """The actions as they are tried: the wanted one, then the others from the best on."""
    yield wanted  # mostly it is free, and nothing needs to be sorted
    others = (action for action in range(len(q_values)) if action != wanted)
    yield from sorted(others, key=lambda action: -q_values[action])


def ranks(wanted: npt.NDArray[np.int64], q_values: npt.NDArray[np.float32]) -> Floats:
    """`in_order` for many agents: the place of each action, (agents, actions), from 0 on."""
    preferred = q_values.astype(np.float64)
    preferred[np.arange(len(wanted)), wanted] = math.inf
    order = np.argsort(-preferred, axis=1, kind="stable")
    places: Floats = np.argsort(order, axis=1, kind="stable").astype(np.float64)
    return places


def answers(
    guard: Guard,
    wanted: npt.NDArray[np.int64],
    q_values: npt.NDArray[np.float32],
    beams: Beams,
    age_s: float,
    moving: Floats | None = None,
) -> tuple[npt.NDArray[np.int64], Floats]:
    """`Guard.answer` for many agents: the action of each, and its share; 0.0 where it stands.

    Where it counts how they move, (agents, 3), each is asked for itself.
    """
    if moving is not None and guard.settings.follows_mps2 is not None:
        return _one_by_one(guard, wanted, q_values, beams, age_s, moving)
    in_time = guard.shares(beams, age_s + guard.settings.evade_s) == 1.0
    shares = guard.shares(beams, age_s)
    if not guard.settings.may_slow:
        shares = np.where(shares == 1.0, shares, 0.0)
    worth = 1000.0 * np.where(in_time, 2.0, shares)
    best: npt.NDArray[np.int64] = np.argmax(worth - ranks(wanted, q_values), axis=1)
    return best, shares[np.arange(len(best)), best]


def _one_by_one(
    guard: Guard,
    wanted: npt.NDArray[np.int64],
    q_values: npt.NDArray[np.float32],
    beams: Beams,
    age_s: float,
    moving: Floats,
) -> tuple[npt.NDArray[np.int64], Floats]:
    actions, shares = wanted.copy(), np.zeros(len(wanted))
    rows = zip(wanted.tolist(), q_values.tolist(), beams.ranges_m, moving.tolist(), strict=True)
    for i, (wish, values, ranges_m, (linear, lateral, angular)) in enumerate(rows):
        twist = linear, lateral, angular
        answer = guard.answer(wish, values, Beams(beams.fan, ranges_m), age_s, twist)
        shares[i] = answer.share
        if answer.action is not None:
            actions[i] = answer.action
    return actions, shares


def _share(twist: Speeds, fan: Fan, way: GroundNeeded, touched_s: float) -> float:
    """The largest share of a motion that ends before it touches something."""
    if not _stays_in_sight(fan, twist, way.full_s):
        return 0.0
    return next((s for s in SHARES if way.at_share_s(s) <= touched_s), 0.0)


def _stays_in_sight(fan: Fan, twist: Speeds, full_s: float) -> bool:
    """Whether a motion begins and ends in the sector that is seen. A turn on the spot does."""
    linear, lateral, angular = twist
    if linear == lateral == 0.0:
        return True
    begins_rad = math.atan2(lateral, linear)
    return fan.sees(begins_rad) and fan.sees(begins_rad + 0.5 * angular * full_s)


def _surely_in_sight(fan: Fan, twist: Speeds, least_s: float, most_s: float) -> bool:
    """`_stays_in_sight`, for all that lies between two lengths of the way."""
    linear, lateral, angular = twist
    if linear == lateral == 0.0:
        return True
    begins_rad = math.atan2(lateral, linear)
    ends_rad = begins_rad + 0.5 * angular * least_s, begins_rad + 0.5 * angular * most_s
    return fan.sees(begins_rad) and fan.sees_arc(*ends_rad)
