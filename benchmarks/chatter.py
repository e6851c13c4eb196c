"""The frontier of contacts against switches: what holding an action, and a margin, cost and save.

    python benchmarks/chatter.py POLICY.onnx… [--rate 50] [--agents 512] [--seconds 60] [--json]

Each policy drives through the reference field at the rate of a robot, with each hold time and each
margin of the grid in the place of its contract's (`choice.py`). Contacts per 100 m of progress;
switches (another action than at the tick before) and reversals (left to right or back, whatever
lies between) a second. A setting is on the frontier if none has fewer switches and fewer contacts.
Validation worlds, because what ships is chosen here; nothing is asserted.
"""

import argparse
import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.policy.policy import LoadedPolicy, load_policy
from reflexarc_sim_bridge.evaluation.driving.pilot import Pilot
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.files import world_named
from reflexarc_sim_bridge.worlds.reference_contract import WORLD_NAME
from reflexarc_sim_bridge.worlds.seeds import validation_seeds

HOLDS_S = (0.0, 0.04, 0.06, 0.1, 0.14, 0.2, 0.26, 0.3)
MARGINS = (0.0, 0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.5)
DISCARDED_S = 5.0


@dataclass(frozen=True)
class Chatter:
    """What one setting does."""

    hold_s: float
    margin: float
    contacts_per_100m: float
    switches_hz: float
    reversals_hz: float
    one_tick: float
    """Share of the held actions that last one tick."""


def chatter(
    policy: LoadedPolicy, contract: PolicyContract, rate_hz: float, agents: int, seconds: float
) -> Chatter:
    """Drive with the hold and the margin of a contract."""
    world = replace(world_named(WORLD_NAME).drawn(0), dt_s=1.0 / rate_hz)
    simulation = Simulation(world, contract, validation_seeds(agents))
    pilot = Pilot(policy, contract, agents, world.dt_s)
    sides = np.array([np.sign(action.lateral_mps) for action in contract.actions], np.int64)
    discarded, counted = round(DISCARDED_S * rate_hz), round(seconds * rate_hz)
    last, last_side = np.zeros(agents, np.int64), np.zeros(agents, np.int64)
    since = np.zeros(agents, np.int64)
    switches = reversals = short = 0
    before = simulation.distance_m.copy(), simulation.contacts.copy()
    for step in range(discarded + counted):
        if step == discarded:
            before = simulation.distance_m.copy(), simulation.contacts.copy()
        simulation.sense()
        actions = pilot.act(simulation.stacks)
        changed, side = actions != last, sides[actions]
        turned = (side != 0) & (last_side == -side)
        if step >= discarded:
            switches, reversals = switches + int(changed.sum()), reversals + int(turned.sum())
            short += int((changed & (step - since == 1)).sum())
        since, last = np.where(changed, step, since), actions.copy()
        last_side = np.where(side != 0, side, last_side)
        pilot.begin_anew(simulation.step(actions))
    metres = float((simulation.distance_m - before[0]).sum())
    contacts = int((simulation.contacts - before[1]).sum())
    time_s = agents * counted / rate_hz
    return Chatter(
        contract.hold_s,
        contract.margin,
        100.0 * contacts / metres,
        switches / time_s,
        reversals / time_s,
        short / max(1, switches),
    )


def frontier(found: Sequence[Chatter]) -> list[Chatter]:
    """Those that none beats in both, the most nervous first."""
    best, kept = math.inf, []
    for each in sorted(found, key=lambda c: (c.contacts_per_100m, c.switches_hz)):
        if each.switches_hz < best:
            best = each.switches_hz
            kept.append(each)
    return sorted(kept, key=lambda c: -c.switches_hz)


def settings(contract: PolicyContract) -> Iterator[PolicyContract]:
    """The contract with each hold time and margin."""
    for hold_s in HOLDS_S:
        for margin in MARGINS:
            yield replace(contract, hold_s=hold_s, margin=margin)


def main() -> None:
    """Print the frontier of each policy, and its first point: no hold, no margin."""
    given = _arguments()
    for path in given.policies:
        policy = load_policy(path, bounds=None)
        found = [
            chatter(policy, each, given.rate, given.agents, given.seconds)
            for each in settings(policy.contract)
        ]
        if given.json:
            print(json.dumps({"policy": str(path), "all": [asdict(each) for each in found]}))
            continue
        print(f"\n{path} at {given.rate:g} Hz: no filter, then the frontier")
        print("  hold, s  margin  contacts/100 m  switches/s  reversals/s  one tick")
        for each in [found[0], *frontier(found)]:
            print(
                f"  {each.hold_s:7.2f} {each.margin:7.2f} {each.contacts_per_100m:15.2f}"
                f" {each.switches_hz:11.2f} {each.reversals_hz:12.2f} {each.one_tick:9.0%}"
            )


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("policies", nargs="+", type=Path)
    parser.add_argument("--rate", type=float, default=50.0)
    parser.add_argument("--agents", type=int, default=512)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--json", action="store_true")
    return parser.parse_args()


if __name__ == "__main__":
    main()
