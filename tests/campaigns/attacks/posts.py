"""The guard: a body of 0.2 m among posts of 4 cm, 0.1 a square metre, with and without it.

On real processes in lockstep, which give the same drive on any machine; and, with --reflex, a crowd
in the simulator by `benchmarks/guard.py`, whose policy sees 16 rays while the guard sees all.
"""

import math
import signal
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from campaigns.attacks.outcome import Outcome, counts, held_if
from campaigns.attacks.stage import Stage
from reflexarc_runtime.contract.body_spec import BodySpec, Footprint
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.contract.motion import sideways_actions
from reflexarc_runtime.policy.policy import load_policy
from support.policies import exported
from support.processes import finished, said_line, started

STEPS = 5000
RADIUS_M = 0.2
RAYS = 176
POSTS = f"""
name = "posts of 4 cm"
edges = "unbounded"
[chassis]
radius_m = {RADIUS_M}
[[layers]]
kind = "scatter"
density_per_m2 = 0.1
[[layers.shapes]]
kind = "discs"
radius_m = [0.02, 0.02]
"""
BENCHMARKS = Path(__file__).parents[3] / "benchmarks"


def on_processes(stage: Stage) -> Iterator[Outcome]:
    """Random weights behind 176 rays, which know nothing of posts."""
    contract = PolicyContract(
        retina=RetinaSpec(rays=RAYS, fov_rad=math.pi, range_m=5.0),
        actions=sideways_actions(),
        body=BodySpec(Footprint(radius_m=RADIUS_M)),
    )
    without, _ = _drive(stage, contract, "--no-guard")
    guarded, verdicts = _drive(stage, contract)
    words = {name: n for name, n in verdicts.items() if name != "STOPPED"}
    yield Outcome(
        "posts of 4 cm, a policy of random weights",
        f"{STEPS} steps in lockstep, {RAYS} rays",
        None,
        f"{_rate(without)} contacts per 100 m without the guard ({without['distance_m']:.0f} m), "
        f"{_rate(guarded)} with it ({guarded['distance_m']:.0f} m; {counts(words)})",
        held_if(without["contacts"] > 0 and guarded["contacts"] == 0),
    )


def in_a_crowd(stage: Stage) -> Iterator[Outcome]:
    """A trained policy."""
    if stage.reflex is None:
        return
    sys.path.insert(0, str(BENCHMARKS))
    from guard import Case, measure  # type: ignore[import-not-found]

    policy = load_policy(stage.reflex, bounds=None)
    off, on = (
        measure(Case("posts 4 cm", "reflex", guard, rays=RAYS), policy, 64, 30.0)
        for guard in ("off", "on")
    )
    yield Outcome(
        "posts of 4 cm, a trained policy of 16 rays",
        f"64 agents, 30 s each, {RAYS} rays for the guard, in the simulator",
        None,
        f"{off.contacts_per_100m:.2f} contacts per 100 m without the guard at "
        f"{off.speed_mps:.2f} m/s, {on.contacts_per_100m:.2f} with it at {on.speed_mps:.2f} m/s",
        held_if(on.contacts_per_100m == 0.0 < off.contacts_per_100m),
    )


def _drive(
    stage: Stage, contract: PolicyContract, *flags: str
) -> tuple[dict[str, Any], dict[str, int]]:
    """The journey, and the runtime's verdicts."""
    port, folder = stage.place()
    policy, world = folder / "policy.onnx", folder / "posts.toml"
    policy.write_bytes(exported(contract, seed=3))
    world.write_text(POSTS)
    common = ("--port", port, "--lockstep", "--json")
    with started("run", policy, *flags, *common, cwd=folder) as loop:
        words = ("sim", "--policy", policy, "--allow-body", "--world", world, "--steps", STEPS)
        with started(*words, *common, cwd=folder) as body:
            said_line(body, "posts")
            journey = finished(body)
        summary = finished(loop, signal.SIGINT)
    return journey, summary["verdicts"]


def _rate(journey: dict[str, Any]) -> str:
    return f"{100 * journey['contacts'] / max(journey['distance_m'], 1e-9):.2f}"


ATTACKS = (on_processes, in_a_crowd)
