"""A simulated robot in a world: it sees, and moves as it is told. It uses neither bus nor clock.

What it is told went through a gate before (`gate/`): whom to obey is not asked here.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from reflexarc_runtime.arrays import Retina
from reflexarc_runtime.beams import Beams, Fan
from reflexarc_runtime.contract.body_limits import BodyLimits
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import WorldError
from reflexarc_runtime.guard import Guard
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.messages.body_info import BodyInfo
from reflexarc_runtime.sweep import Speeds
from reflexarc_sim_bridge.body.gate.limits import Motion, Twist
from reflexarc_sim_bridge.simulation.moving_house import move_house
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.files import parse_world
from reflexarc_sim_bridge.worlds.world import World

MAX_STEP_M = 100.0
"""A body that went farther in one step could meet so much that listing it takes minutes."""

CHECK_MARGIN_M = 0.02
"""Less than a runtime's guard keeps: the body steps in where that one was late, or is not there."""


@dataclass(frozen=True, slots=True)
class BodyPose:
    """Position and heading of the robot, in the world's frame."""

    x_m: float
    y_m: float
    heading_rad: float = 0.0
    """Counter-clockwise from x; 0 for a robot that only moves sideways."""


class Body:
    """A robot with the eye of a contract.

    Args:
        world: the world that it drives in.
        contract: its eye, its fastest motions, and its safe command.
        rate_hz: steps of the simulation a second.
        seed: of the world.
        number: which of several robots in one world; each has places of its own.
        world_text: the file of the world, which the body tells others.
        checks: the body looks for itself, along its own rays, whether the commanded way is free,
            and goes slower or stands where it is not.
        all_round: see `Simulation`.

    Raises:
        WorldError: the contract asks for a sense or a motion that the world does not have, or for
            too much speed to simulate; or the world, for a longer latency than fits in such steps.
    """

    def __init__(
        self,
        world: World,
        contract: PolicyContract,
        rate_hz: float,
        seed: int,
        number: int = 0,
        world_text: str = "",
        *,
        checks: bool = False,
        all_round: bool = False,
    ) -> None:
        step_s = 1.0 / rate_hz
        _check_speed(contract, step_s)
        self.contract = contract
        self.info = BodyInfo(
            world.name,
            world_text,
            seed,
            number,
            step_s,
            _limits_of(contract).narrowed(world.limits),
        )
        self.simulation = Simulation(
            _in_steps_of(world, step_s),
            contract,
            np.array([seed], np.uint64),
            lanes=np.array([number], np.uint64),
            all_round=all_round,
        )
        self.contacts = 0
        self.held_back = 0
        """Steps at which its own check made it slower, or stand."""
        self._check = _check_of(world, contract, step_s) if checks else None
        self._fan = _fan_of(self.simulation)

    @property
    def limits(self) -> BodyLimits:
        """What it does at most: the world's limits, and the fastest of its contract's actions."""
        assert self.info.limits is not None
        return self.info.limits

    @property
    def safe(self) -> Motion:
        """What it does with nothing to obey: the safe command of its contract."""
        action = self.contract.safe_command
        return Motion(action.linear_mps, action.lateral_mps, action.angular_radps)

    def take_over(self, former: "Body") -> None:
        """Go on where another body of the same world is: its place, its way and its counts."""
        move_house(self.simulation, former.simulation)
        self.contacts, self.held_back = former.contacts, former.held_back

    def move(self, motion: Twist) -> BodyPose | None:
        """Move for one period.

        Returns:
            Where a collision began, to within the sideways motion of one step; None without a
            collision. After one the robot stands elsewhere.
        """
        before = self.place
        twist = motion.linear_mps, motion.lateral_mps, motion.angular_radps
        if self._check is not None:
            twist = self._checked(self._check, twist)
        if not self.simulation.drive(*twist):
            return None
        self.contacts += 1
        return replace(before, x_m=self.place.x_m)

    def _checked(self, check: Guard, twist: Speeds) -> Speeds:
        """The commanded motion, at the share of its speed at which its way is free."""
        spec = self.contract.retina
        distances_m = self.simulation.distances().astype(np.float64)
        ranges_m = np.where(distances_m < spec.range_m, distances_m, math.inf)
        state = self.simulation.params.agents.state[0]
        ahead, left, turn = state["linear_mps"], state["lateral_mps"], state["angular_radps"]
        seen = Beams(self._fan, ranges_m)
        share = check.share(twist, seen, 0.0, (float(ahead), float(left), float(turn)))
        self.held_back += share < 1.0
        return share * twist[0], share * twist[1], share * twist[2]

    @property
    def guard_state(self) -> str:
        """What the status topic says about its own check."""
        return "off" if self._check is None else "on"

    @property
    def sends_anew(self) -> bool:
        """Whether its sensor sends a new retina now; a slow one does so only every few steps."""
        state = self.simulation.params.agents.state[0]
        return bool(state["looks"] == 0 or state["steps"] >= state["due"])

    def see(self) -> Retina:
        """The retina now: uint8 (eyes, rays, channels). To be asked for once a step."""
        retina: Retina = self.simulation.sense()[0]
        return retina

    @property
    def place(self) -> BodyPose:
        """Its position and heading now."""
        here = self.simulation
        return BodyPose(float(here.x_m[0]), float(here.y_m[0]), float(here.heading_rad[0]))


def rebuild(
    info: BodyInfo, contract: PolicyContract, *, checks: bool = False, all_round: bool = False
) -> Body:
    """The body that a log tells of, as it was when it began: in the same world, at the same place.

    Args:
        info: what it said on `<robot>/body`.
        contract: of the policy that drove it.
        checks: see `Body`.
        all_round: see `Simulation`.

    Raises:
        WorldError: it was not simulated, or its text is no world.
    """
    if not (info.world_text and info.step_s):
        raise WorldError("body: expected the text of a world and a step, got a body without")
    world = parse_world(info.world_text, info.world).drawn(info.seed)
    return Body(
        world,
        contract,
        1.0 / info.step_s,
        info.seed,
        info.number,
        info.world_text,
        checks=checks,
        all_round=all_round,
    )


def _in_steps_of(world: World, step_s: float) -> World:
    """The same world in steps of another duration: its times and its slip stay what they are."""
    try:
        return replace(world, dt_s=step_s)
    except WorldError as error:
        raise WorldError(f"{error}; a lower --rate makes the steps longer") from None


def _check_of(world: World, contract: PolicyContract, step_s: float) -> Guard:
    """The check of a body: its real outline and brakes, and its looks, which are never old.

    Raises:
        WorldError: two eyes, whose rays do not begin at one place.
    """
    if contract.retina.eyes != 1:
        raise WorldError(f"body: expected one eye to check with, got {contract.retina.eyes}")
    body = world.body
    delay_s, braking = body.actuation_delay_s, body.deceleration_mps2
    known = GuardSettings(CHECK_MARGIN_M, body.footprint, delay_s, braking)
    return Guard(known, contract.actions, step_s)


def _fan_of(simulation: Simulation) -> Fan:
    """The directions in which its eye really looks, however it is mounted."""
    bearings_rad, half_rad = simulation.bearings_rad, 0.5 * simulation.contract.retina.fov_rad
    middle_rad = simulation.world.drawn(0).senses.mounted_rad
    edges_rad = middle_rad - half_rad, middle_rad + half_rad
    return Fan(np.cos(bearings_rad), np.sin(bearings_rad), *edges_rad)


def _check_speed(contract: PolicyContract, step_s: float) -> None:
    motions = (*contract.actions, contract.safe_command)
    fastest_mps = max(math.hypot(motion.linear_mps, motion.lateral_mps) for motion in motions)
    if not fastest_mps * step_s <= MAX_STEP_M:
        raise WorldError(
            f"body: expected at most {MAX_STEP_M:g} m in a step, got {fastest_mps:g} m/s for "
            f"{step_s:g} s; a higher --rate makes the steps shorter"
        )


def _limits_of(contract: PolicyContract) -> BodyLimits:
    """The fastest of the contract's actions, in each direction."""
    return BodyLimits(
        linear_mps=max(abs(action.linear_mps) for action in contract.actions),
        lateral_mps=max(abs(action.lateral_mps) for action in contract.actions),
        angular_radps=max(abs(action.angular_radps) for action in contract.actions),
    )
