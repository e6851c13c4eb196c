"""The frontier of contacts against switches: what holding an action, and a margin, cost and save.

    python benchmarks/chatter.py POLICY.onnx… [--rate 50] [--agents 512] [--seconds 60]
        [--figure docs/figures/chatter.png] [--json]

The policies, such as seeds of one preset, drive through the reference field at the rate of a robot,
with each setting of two grids in the place of their contracts' (`choice.py`): holds and margins
that are a share of the Q-values' spread, holds and least leads in the Q-values' own unit. Contacts
per 100 m of progress; switches (another action than at the tick before) and reversals (left to
right or back, whatever lies between) a second: means over the policies. A setting is on the
frontier of its grid if none of it has fewer switches and fewer contacts. The knee is the setting
with the fewest switches of those with at most 5 % more contacts than without any. Validation
worlds, because what ships is chosen here; nothing is asserted.
"""

import argparse
import json
import math
from collections.abc import Sequence
from dataclasses import asdict, astuple, dataclass, replace
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.policy.policy import Policy, load_policy
from reflexarc_sim_bridge.evaluation.driving.pilot import Pilot
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.files import world_named
from reflexarc_sim_bridge.worlds.reference_contract import WORLD_NAME
from reflexarc_sim_bridge.worlds.seeds import validation_seeds

HOLDS_S = (0.0, 0.06, 0.1, 0.14, 0.2)
MARGINS = (0.0, 0.1, 0.2, 0.3, 0.5)
LEADS = (0.02, 0.04, 0.06, 0.07, 0.08, 0.1, 0.14)
DISCARDED_S = 5.0
ALLOWED = 1.05
"""Contacts at the knee, at most, of those without any setting."""


@dataclass(frozen=True)
class Chatter:
    """What one setting does."""

    hold_s: float
    margin: float
    least_lead: float
    contacts_per_100m: float
    switches_hz: float
    reversals_hz: float
    one_tick: float
    """Share of the held actions that last one tick."""


def chatter(
    policy: Policy, contract: PolicyContract, rate_hz: float, agents: int, seconds: float
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
        contract.least_lead,
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


def grid(margins: Sequence[float], leads: Sequence[float]) -> list[dict[str, float]]:
    """Each hold time with each margin and least lead, as fields of a contract."""
    return [
        {"hold_s": hold_s, "margin": margin, "least_lead": lead}
        for hold_s in HOLDS_S
        for margin in margins
        for lead in leads
    ]


def mean(found: Sequence[Chatter]) -> Chatter:
    """Of one setting, over policies."""
    return Chatter(*np.mean([astuple(each) for each in found], axis=0).tolist())


def knee(found: Sequence[Chatter], free: Chatter) -> Chatter:
    """The fewest switches of those with at most 5 % more contacts than without any setting."""
    most = ALLOWED * free.contacts_per_100m
    fitting = [each for each in found if each.contacts_per_100m <= most]
    return min([free, *fitting], key=lambda each: each.switches_hz)


def draw(path: Path, free: Chatter, grids: dict[str, list[Chatter]]) -> None:
    """The frontier of each grid, and all else that was tried, pale."""
    figure = Figure(figsize=(7.0, 4.4), dpi=140, layout="constrained")
    FigureCanvasAgg(figure)
    axes: Axes = figure.add_subplot()
    for (name, found), colour in zip(grids.items(), ("tab:orange", "tab:blue"), strict=True):
        best = frontier(found)
        x, y = [e.switches_hz for e in found], [e.contacts_per_100m for e in found]
        axes.plot(x, y, ".", color=colour, alpha=0.3)
        x, y = [e.switches_hz for e in best], [e.contacts_per_100m for e in best]
        axes.plot(x, y, "o-", color=colour, label=name)
    axes.plot(free.switches_hz, free.contacts_per_100m, "ks", label="the winner at every tick")
    axes.axvline(free.switches_hz / 5.0, color="grey", linestyle=":", label="a fifth, and +5 %")
    axes.axhline(ALLOWED * free.contacts_per_100m, color="grey", linestyle=":")
    axes.set_xscale("log")
    axes.set_xticks([0.5, 1, 2, 3, 6], labels=["0.5", "1", "2", "3", "6"])
    axes.minorticks_off()
    axes.set_ylim(0.0, 2.5 * free.contacts_per_100m)
    axes.set_xlabel("switches a second")
    axes.set_ylabel("contacts per 100 m")
    axes.grid(alpha=0.3)
    axes.legend(loc="lower left")
    figure.savefig(path)


def show(name: str, found: Sequence[Chatter]) -> None:
    """Rows of the table."""
    print(f"\n{name}")
    print("  hold, s  margin    lead  contacts/100 m  switches/s  reversals/s  one tick")
    for each in found:
        print(
            f"  {each.hold_s:7.2f} {each.margin:7.2f} {each.least_lead:7.2f}"
            f" {each.contacts_per_100m:15.2f} {each.switches_hz:11.2f} {each.reversals_hz:12.2f}"
            f" {each.one_tick:9.0%}"
        )


def main() -> None:
    """Print the frontier of each grid and its knee; draw them if a file is named."""
    given = _arguments()
    policies = [load_policy(path, bounds=None) for path in given.policies]

    def measured(setting: dict[str, float]) -> Chatter:
        contracts = [replace(policy.contract, **setting) for policy in policies]
        size = given.rate, given.agents, given.seconds
        return mean([chatter(p, c, *size) for p, c in zip(policies, contracts, strict=True)])

    shares, leads = grid(MARGINS, (0.0,)), grid((0.0,), LEADS)
    grids = {
        "hold, and a share of the spread": [measured(each) for each in shares],
        "hold, and a lead in Q": [measured(each) for each in leads],
    }
    free = next(iter(grids.values()))[0]
    if given.json:
        rows = {name: [asdict(each) for each in found] for name, found in grids.items()}
        print(json.dumps({"policies": [str(path) for path in given.policies], "grids": rows}))
    else:
        show(f"no setting, at {given.rate:g} Hz; mean of {len(policies)}", [free])
        for name, found in grids.items():
            show(f"{name}: the frontier", frontier(found))
            show("  its knee", [knee(found, free)])
    if given.figure:
        draw(given.figure, free, grids)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("policies", nargs="+", type=Path)
    parser.add_argument("--rate", type=float, default=50.0)
    parser.add_argument("--agents", type=int, default=512)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--figure", type=Path, help="file to draw the frontiers to")
    parser.add_argument("--json", action="store_true")
    return parser.parse_args()


if __name__ == "__main__":
    main()
