"""`reflexarc evaluate`: measures how often a policy collides on the reference field."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import tyro

from reflexarc.terminal.output import console, print_json, progress_bar
from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from reflexarc_sim_bridge.evaluation.reference_field import FieldScore


@dataclass(frozen=True)
class EvaluateCommand:
    """Measure policies on the reference field's test worlds, beside an agent that never steers.

    The figure is contacts per 100 m, with a 95 % interval (bootstrap over agents). Policies are
    greedy and decide at every step; each has its own eye.

    Examples:
      reflexarc evaluate runs/reflex-0/policy.onnx
      reflexarc evaluate runs/*/policy.onnx --agents 1024 --json
    """

    policies: tyro.conf.Positional[tuple[Path, ...]]
    """Exported policies (ONNX)."""
    agents: int = 4096
    """Agents, each in a world of its own."""
    steps: int = 2000
    """Counted steps of each agent; 100 more come first and do not count."""
    guard: bool = False
    """Drive behind the guard that `reflexarc run` has, and say how often it stepped in. The agent
    that never steers drives without one."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> int:
        """Measure, and print a table."""
        if self.agents < 1 or self.steps < 1:
            raise UsageError(f"--agents, --steps: expected ≥ 1, got {self.agents}, {self.steps}")
        scores = self._measure_all()
        blind = scores["blind"].contacts_per_100m
        if self.json:
            print_json({name: _plain(score, blind) for name, score in scores.items()})
            return 0
        console.print(_table(scores, blind, guarded=self.guard))
        return 0

    def _measure_all(self) -> "dict[str, FieldScore]":
        from reflexarc_runtime.guard_settings import GuardSettings
        from reflexarc_runtime.policy.policy import load_policy
        from reflexarc_sim_bridge.evaluation.reference_field import measure
        from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy
        from reflexarc_sim_bridge.worlds.reference_contract import reference_contract

        loaded = {str(path): load_policy(path, bounds=None) for path in self.policies}
        for name, policy in loaded.items():
            if any(action.angular_radps for action in policy.contract.actions):
                raise UsageError(
                    f"{name}: expected a body that moves sideways, got one that turns; the field "
                    "counts progress along x, which it has not: see its training's report.md"
                )
        scores = {}
        with progress_bar("blind", self.steps) as progress:
            scores["blind"] = measure(
                BlindPolicy(),
                reference_contract(),
                agents=self.agents,
                steps=self.steps,
                progress=progress,
            )
        for name, policy in loaded.items():
            with progress_bar(name, self.steps) as progress:
                scores[name] = measure(
                    policy,
                    policy.contract,
                    agents=self.agents,
                    steps=self.steps,
                    guard=GuardSettings.of(policy.contract) if self.guard else None,
                    progress=progress,
                )
        return scores


def _plain(score: "FieldScore", blind: float) -> dict[str, float]:
    return {
        "contacts_per_100m": score.contacts_per_100m,
        "low": score.low,
        "high": score.high,
        "share_of_blind": score.contacts_per_100m / blind,
        "contacts": score.contacts,
        "distance_m": score.distance_m,
        "agents": score.agents,
        "guarded": score.guarded,
        "stuck": score.stuck,
    }


def _table(scores: "dict[str, FieldScore]", blind: float, *, guarded: bool) -> object:
    from rich.table import Table

    table = Table(title="Reference field, test worlds: contacts per 100 m", title_justify="left")
    more = ("guarded", "stuck") if guarded else ()
    for name in ("policy", "contacts / 100 m", "95 % interval", "of blind", *more):
        table.add_column(name, justify="left" if name == "policy" else "right")
    for name, score in scores.items():
        interval = f"{score.low:.2f} – {score.high:.2f}"
        share = f"{score.contacts_per_100m / blind:.2f}"
        did = (f"{score.guarded:.1%}", f"{score.stuck:.1%}") if guarded else ()
        table.add_row(name, f"{score.contacts_per_100m:.2f}", interval, share, *did)
    return table
