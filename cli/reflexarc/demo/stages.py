"""The stages of the demo: each takes files and returns figures."""

from collections.abc import Callable
from pathlib import Path

from reflexarc.demo.results import LearningResult, LogResult, ReplayResult
from reflexarc.terminal.output import progress_bar
from reflexarc.terminal.progress import show_progress
from reflexarc_logs.reading.summary import summarise
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.policy.policy import Policy, load_policy
from reflexarc_sim_bridge.evaluation.reference_field import FieldScore, measure
from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy, RandomPolicy
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from reflexarc_trainer.config.presets import preset_named
from reflexarc_trainer.run.train import TrainResult, train

PRESET = "reflex"


def learn(out: Path, should_stop: Callable[[], bool]) -> TrainResult:
    """Train the default preset into `out`."""
    with show_progress() as progress:
        return train(preset_named(PRESET), out, progress=progress, should_stop=should_stop)


def measure_learning(result: TrainResult, agents: int) -> LearningResult:
    """Measure blind, random and learned on the reference field's test worlds."""
    policy = load_policy(result.policy_path)
    blind = _measure("blind", BlindPolicy(), reference_contract(), agents)
    random = _measure("random", RandomPolicy(0), reference_contract(), agents)
    learned = _measure("learned", policy, policy.contract, agents)
    return LearningResult(
        preset=PRESET,
        steps=result.steps,
        seconds=result.seconds,
        agents=agents,
        blind_contacts_per_100m=blind.contacts_per_100m,
        random_contacts_per_100m=random.contacts_per_100m,
        learned_contacts_per_100m=learned.contacts_per_100m,
        learned_low=learned.low,
        learned_high=learned.high,
        share_of_blind=learned.contacts_per_100m / blind.contacts_per_100m,
    )


def look_at_log(path: Path) -> LogResult:
    """Count what was recorded."""
    summary = summarise(path)
    return LogResult(str(path), summary.messages, summary.bytes, summary.duration_s)


def replay_log(path: Path) -> ReplayResult:
    """Replay the whole drive at both levels."""
    report = replay(path)
    levels = {
        level.level: {"compared": level.compared, "identical": level.identical}
        for level in report.levels
    }
    return ReplayResult(report.verdict, levels)


def _measure(name: str, policy: Policy, contract: PolicyContract, agents: int) -> FieldScore:
    with progress_bar(f"measuring: {name}", 1) as progress:
        return measure(policy, contract, agents=agents, progress=progress)
