"""From what a run has learned to the policy file."""

from pathlib import Path

from reflexarc_runtime.contract import PolicyContract
from reflexarc_trainer import checkpoint
from reflexarc_trainer.export import export
from reflexarc_trainer.history import Row
from reflexarc_trainer.learner import Learner
from reflexarc_trainer.provenance import provenance_of
from reflexarc_trainer.validation import drive_and_record


def deliver(learner: Learner, history: list[Row], path: Path) -> PolicyContract:
    """Export the learner's network, with its provenance, checked on retinas that it met.

    Raises:
        PolicyError: the backends do not agree; then nothing is written.
    """
    network = learner.network()
    scores = {"steps": float(learner.step)}
    if history:
        scores["validation_contacts_per_100m"] = history[-1].validation_contacts_per_100m
    contract = learner.config.contract(provenance_of(learner.config, scores))
    return export(network, contract, path, recorded=drive_and_record(network, learner.config))


def export_checkpoint(source: Path, out: Path) -> PolicyContract:
    """Export the policy of a checkpoint, finished or not.

    Raises:
        UsageError: `source` is no checkpoint.
        PolicyError: the backends do not agree; then nothing is written.
    """
    saved = checkpoint.load(source)
    return deliver(saved.learner(), saved.history, out)
