"""What does the guard prevent, and what does it cost?

    python benchmarks/guard.py [--reflex POLICY.onnx] [--agents 64] [--seconds 100] [--json]

Policies without and with the guard, in small worlds of posts, boxes and walkers: contacts per 100 m
of way, how often the guard steps in, the share of time standing, and the speed beside that of the
same policy without it. Each agent begins anew after a contact. Without --reflex, the lines of the
trained policy are left out. Guard: `on` is the default, `only stops` never slows down, `late` takes
no other action before it must. Nothing is asserted.
"""

import argparse
import json
import math
import time
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from reflexarc_runtime.contract.body_spec import BodySpec, Footprint
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.contract.motion import sideways_actions
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.policy.policy import load_policy
from reflexarc_sim_bridge.evaluation.driving.crowd_guard import CrowdGuard
from reflexarc_sim_bridge.evaluation.driving.pilot import Pilot
from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy, RandomPolicy
from reflexarc_sim_bridge.simulation.simulation import Simulation, motions_of
from reflexarc_sim_bridge.worlds.layer_motion import Drift
from reflexarc_sim_bridge.worlds.layers import Scatter
from reflexarc_sim_bridge.worlds.seeds import test_seeds
from reflexarc_sim_bridge.worlds.shapes import Discs, Rectangles
from reflexarc_sim_bridge.worlds.world import Chassis, World

RADIUS_M = 0.2
POST_DENSITY = 0.1
STANDING_MPS = 0.05

LAYERS: dict[str, tuple[Scatter, ...]] = {
    **{
        f"posts {2 * r * 100:g} cm": (Scatter(POST_DENSITY, shapes=(Discs((r, r)),)),)
        for r in (0.01, 0.02, 0.05)
    },
    "boxes": (Scatter(0.1, shapes=(Rectangles((0.3, 1.5), (0.3, 1.2)),)),),
    "walkers": tuple(
        Scatter(0.02, shapes=(Discs((0.2, 0.3)),), motion=Drift(ahead_mps=x, left_mps=y))
        for x, y in ((0.0, 0.7), (0.0, -0.7), (-0.7, 0.0))
    ),
}


@dataclass(frozen=True)
class Case:
    """One line of the table."""

    world: str
    policy: str
    guard: str
    rate_hz: float = 10.0
    rays: int = 16
    brakes: bool = False


@dataclass(frozen=True)
class Result:
    """What was measured."""

    contacts_per_100m: float
    guarded: float
    stuck: float
    standing: float
    speed_mps: float


class InvertedPolicy:
    """Wants most what another policy wants least."""

    def __init__(self, policy: Any) -> None:
        self._policy = policy

    def decide(self, retinas: Any) -> Any:
        """See `Policy.decide`."""
        q_values, _ = self._policy.decide(retinas)
        return -q_values, (-q_values).argmax(axis=1)


class Resampled:
    """Shows a policy of 16 rays every n-th ray of a finer eye: the guard sees what it does not."""

    def __init__(self, policy: Any, rays: int) -> None:
        self._policy, self._rays = policy, rays

    def decide(self, retinas: Any) -> Any:
        """See `Policy.decide`."""
        step = retinas.shape[-2] // self._rays
        return self._policy.decide(np.ascontiguousarray(retinas[..., step // 2 :: step, :]))


def contract_of(case: Case) -> PolicyContract:
    """What the policy of a case sees, does, and believes of its body."""
    body = BodySpec(Footprint(radius_m=RADIUS_M), deceleration_mps2=1.0 if case.brakes else None)
    eye = RetinaSpec(rays=case.rays, fov_rad=math.pi, range_m=5.0)
    age_s = 1.0 / case.rate_hz
    return PolicyContract(
        retina=eye,
        actions=sideways_actions(),
        body=body,
        rate_hz=case.rate_hz,
        max_input_age_s=age_s,
    )


def world_of(case: Case) -> World:
    """The obstacles of a case, and the body that moves among them."""
    braking = 1.0 if case.brakes else math.inf
    chassis = Chassis(radius_m=RADIUS_M, acceleration_mps2=braking)
    return World("bench", layers=LAYERS[case.world], chassis=chassis, dt_s=1.0 / case.rate_hz)


def measure(case: Case, policy: Any, agents: int, seconds: float) -> Result:
    """Let a crowd drive, and count contacts, interventions, standing and way."""
    contract, world = contract_of(case), world_of(case)
    crowd, moves = None, contract
    if case.guard != "off":
        known = replace(GuardSettings.of(contract), may_slow=case.guard == "on")
        if case.guard == "late":
            known = replace(known, may_slow=True, evade_s=0.0)
        crowd = CrowdGuard(known, contract, world.dt_s)
        moves = crowd.contract
    simulation = Simulation(world, moves, test_seeds(agents))
    seen = Resampled(policy, 16) if case.rays > 16 else policy
    pilot = Pilot(seen, contract, agents, world.dt_s, crowd)
    speeds = np.hypot(*motions_of(moves)[:, :2].T)
    way_m, standing, steps = 0.0, 0, round(seconds * case.rate_hz)
    for _ in range(steps):
        simulation.sense()
        rows = pilot.act(simulation.stacks)
        simulation.step(rows)
        state = simulation.params.agents.state
        moving = (
            np.hypot(state["linear_mps"], state["lateral_mps"]) if case.brakes else speeds[rows]
        )
        way_m += float(moving.sum()) * world.dt_s
        standing += int((moving < STANDING_MPS).sum())
    did, contacts = crowd.did if crowd else None, int(simulation.contacts.sum())
    return Result(
        100.0 * contacts / max(way_m, 1e-9),
        did.guarded / did.decisions if did else 0.0,
        did.stuck / did.decisions if did else 0.0,
        standing / (agents * steps),
        way_m / (agents * seconds),
    )


def cases(has_reflex: bool) -> list[Case]:
    """All rows of the table; those of a trained policy only where there is one."""
    names = ["random", "constant", *(["inverted", "reflex"] if has_reflex else [])]
    best = names[-1]
    grid = [
        Case(world, name, guard) for world in LAYERS for name in names for guard in ("off", "on")
    ]
    rates = [
        Case("posts 4 cm", best, guard, rate_hz=rate, rays=rays)
        for rate in (5.5, 10.0, 20.0, 40.0)
        for rays in (16, 176)
        for guard in ("off", "on")
        if (rate, rays) != (10.0, 16)
    ]
    braking = [
        Case(world, best, guard, rays=176, brakes=True, rate_hz=20.0)
        for world in ("posts 4 cm", "boxes", "walkers")
        for guard in ("off", "on", "only stops", "late")
    ]
    fine = [
        Case(w, n, g, rays=176)
        for w in ("posts 2 cm", "boxes", "walkers")
        for n in names
        for g in ("off", "on")
    ]
    stops = [Case("posts 4 cm", best, guard, rays=176) for guard in ("only stops", "late")]
    return [*grid, *fine, *rates, *stops, *braking]


def row_of(case: Case, result: Result) -> str:
    """A line of the table, in Markdown."""
    brakes = "1 m/s²" if case.brakes else "at once"
    return (
        f"| {case.world} | {case.policy} | {case.rays} | {case.rate_hz:g} | {brakes} "
        f"| {case.guard} "
        f"| {result.contacts_per_100m:.2f} | {result.guarded:.1%} | {result.stuck:.1%} "
        f"| {result.standing:.1%} | {result.speed_mps:.2f} |"
    )


def main() -> None:
    """Measure every case, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--reflex", type=Path, help="a trained policy of 16 rays")
    parser.add_argument("--agents", type=int, default=64)
    parser.add_argument("--seconds", type=float, default=100.0)
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args()
    policies: dict[str, Any] = {"random": RandomPolicy(0), "constant": BlindPolicy()}
    if given.reflex:
        policies["reflex"] = load_policy(given.reflex, bounds=None)
        policies["inverted"] = InvertedPolicy(policies["reflex"])
    began_s = time.monotonic()
    if not given.json:
        print(
            "| world | policy | rays | Hz | brakes | guard | contacts / 100 m | guarded | stuck "
            "| standing | m/s |"
        )
        print("|---|---|---|---|---|---|---|---|---|---|---|")
    for case in cases(bool(given.reflex)):
        result = measure(case, policies[case.policy], given.agents, given.seconds)
        if given.json:
            print(json.dumps({**asdict(case), **asdict(result)}), flush=True)
        else:
            print(row_of(case, result), flush=True)
    print(f"{time.monotonic() - began_s:.0f} s")


if __name__ == "__main__":
    main()
