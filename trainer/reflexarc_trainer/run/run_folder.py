"""The folder of a run: its files, and how each is written.

    policy.onnx        the policy with the last weights: see `policy/export.py`
    policy-best.onnx   the policy of the best validation point
    report.md          one page about the run: see `report.py`; it shows the two pictures
    curve.png          contacts over steps
    occupancy.png      share of the time at each lateral position
    metrics.csv        one row per validation point: see `history.py`
    config.json        the resolved configuration, its hash, versions and commit
    checkpoint.npz     the state of the run, from which `train.resume` continues

Each file is written under another name and then renamed, so that it is whole or absent.
"""

import json
from pathlib import Path

from reflexarc_runtime.files import write_atomically
from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.policy.provenance import commit, versions
from reflexarc_trainer.policy.weights import Weights, network_of, unpack
from reflexarc_trainer.run import checkpoint
from reflexarc_trainer.run.checkpoint import Checkpoint
from reflexarc_trainer.run.delivery import deliver
from reflexarc_trainer.run.history import Row, best_of, to_csv
from reflexarc_trainer.run.plots import draw_curve, draw_occupancy
from reflexarc_trainer.run.report import write_report
from reflexarc_trainer.sarsa.learner_interface import Learner

POLICY, BEST, CONFIG, METRICS = "policy.onnx", "policy-best.onnx", "config.json", "metrics.csv"
CURVE, CHECKPOINT = "curve.png", "checkpoint.npz"
REPORT, OCCUPANCY = "report.md", "occupancy.png"

_MADE = (POLICY, BEST, REPORT, CURVE, OCCUPANCY, METRICS, CHECKPOINT)


class RunFolder:
    """The folder that a run writes into."""

    def __init__(self, path: Path) -> None:
        self.path = path

    @property
    def policy(self) -> Path:
        """Path of the policy with the last weights."""
        return self.path / POLICY

    @property
    def best_policy(self) -> Path:
        """Path of the policy of the best validation point."""
        return self.path / BEST

    def begin(self, config: TrainConfig) -> None:
        """Write the configuration, and remove the files of an earlier run."""
        for name in _MADE:
            (self.path / name).unlink(missing_ok=True)
        document = {
            "config": config.resolved(),
            "config_hash": config.hash,
            "versions": versions(),
            "commit": commit(),
        }
        self._write(CONFIG, (json.dumps(document, indent=2) + "\n").encode())

    def save(self, learner: Learner, history: list[Row], best: Weights) -> None:
        """Write the checkpoint and the metrics."""
        checkpoint.save(self.path / CHECKPOINT, learner, history, best)
        self._write(METRICS, to_csv(history))

    def load(self) -> Checkpoint:
        """The checkpoint.

        Raises:
            UsageError: there is none, or it is of another version.
        """
        return checkpoint.load(self.path / CHECKPOINT)

    def finish(self, learner: Learner, history: list[Row], best: Weights) -> None:
        """Write the policies, the pictures and the report.

        Raises:
            PolicyError: the backends do not agree on a policy.
        """
        config, network = learner.config, network_of(learner)
        last, best_point = history[-1] if history else None, best_of(history)
        deliver(network, config, learner.step, last, self.policy)
        if best_point is not None:
            best_network = unpack(best, config.contract(), config.network)
            deliver(best_network, config, best_point.step, best_point, self.best_policy)
        self._write(CURVE, draw_curve(config, history))
        self._write(OCCUPANCY, draw_occupancy(network, config))
        self._write(REPORT, write_report(network, config, learner.step, history).encode())

    def _write(self, name: str, data: bytes) -> None:
        write_atomically(self.path / name, data)
