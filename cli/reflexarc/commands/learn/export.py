"""`reflexarc export`: a checkpoint becomes a policy file."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from reflexarc.terminal.output import console, facts, print_json


@dataclass(frozen=True)
class ExportCommand:
    """Export a checkpoint as one self-describing ONNX file.

    Nothing is written unless the ONNX checker passes and torch, onnxruntime and NumPy agree.

    Examples:
      reflexarc export runs/reflex-0/checkpoint.npz -o policy.onnx
    """

    checkpoint: tyro.conf.Positional[Path]
    """Checkpoint of a training run."""
    out: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """The file to write."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> int:
        """Export, and say what the policy is."""
        from reflexarc_runtime.policy.policy import load_policy
        from reflexarc_trainer.run.delivery import export_checkpoint

        export_checkpoint(self.checkpoint, self.out)
        policy = load_policy(self.out, bounds=None)
        if self.json:
            print_json({"policy": self.out, "policy_hash": policy.policy_hash})
        else:
            console.print(facts({"policy": self.out, "hash": policy.policy_hash}))
        return 0
