"""The policy file of a run: export of its network, with the run's provenance and scores."""

from pathlib import Path

from reflexarc_runtime.contract.contract import PolicyContract
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
    """Export a network with its provenance, checked on retinas of a drive with it.

    Args:
        network: the learned network.
        config: the run that learned it.
        step: transitions that it learned from.
        point: the validation point with its score, if there is one.
        path: the file.

    Raises:
        PolicyError: the backends do not agree; nothing is written.
    """
    scores = {"steps": float(step)}
    if point is not None:
        scores["validation_contacts_per_100m"] = point.validation_contacts_per_100m
    contract = config.contract(provenance_of(config, scores))
    return export(network, contract, path, recorded=drive_and_record(network, config))


def export_checkpoint(source: Path, out: Path) -> PolicyContract:
    """Export the policy of a checkpoint, finished or not.

    Raises:
        UsageError: `source` is not a checkpoint of this version.
        PolicyError: the backends do not agree; nothing is written.
    """
    saved = checkpoint.load(source)
    learner, last = saved.learner(), saved.history[-1] if saved.history else None
    return deliver(network_of(learner), learner.config, learner.step, last, out)
