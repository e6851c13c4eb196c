"""From what a run has learned to the policy file."""

from pathlib import Path

from reflexarc_runtime.contract import PolicyContract
from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.policy.export import export
from reflexarc_trainer.policy.provenance import provenance_of
from reflexarc_trainer.policy.q_network import QNetwork
from reflexarc_trainer.policy.weights import network_of
from reflexarc_trainer.run import checkpoint
from reflexarc_trainer.run.history import Row
from reflexarc_trainer.run.validation import drive_and_record


def deliver(
    network: QNetwork, config: TrainConfig, step: int, point: Row | None, path: Path
) -> PolicyContract:
    """Export a network, with its provenance, checked on retinas that it met.

    Args:
        network: what was learned.
        config: by which run.
        step: from how many transitions.
        point: the validation point that says how good it is.
        path: the file.

    Raises:
        PolicyError: the backends do not agree; then nothing is written.
    """
    scores = {"steps": float(step)}
    if point is not None:
        scores["validation_contacts_per_100m"] = point.validation_contacts_per_100m
    contract = config.contract(provenance_of(config, scores))
    return export(network, contract, path, recorded=drive_and_record(network, config))


def export_checkpoint(source: Path, out: Path) -> PolicyContract:
    """Export the policy of a checkpoint, finished or not.

    Raises:
        UsageError: `source` is no checkpoint.
        PolicyError: the backends do not agree; then nothing is written.
    """
    saved = checkpoint.load(source)
    learner, last = saved.learner(), saved.history[-1] if saved.history else None
    return deliver(network_of(learner), learner.config, learner.step, last, out)
