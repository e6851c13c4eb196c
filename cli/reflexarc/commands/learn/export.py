"""`reflexarc export`: a checkpoint becomes a policy file; a log becomes a bag, or a table."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from reflexarc.terminal.output import console, facts, plain, print_json
from reflexarc.wiring.exchange.log_exports import EXPORTS, export_log
from reflexarc_runtime.errors import UsageError


@dataclass(frozen=True)
class ExportCommand:
    """Export a checkpoint as one self-describing ONNX file; or a log for other tools.

    Of a checkpoint nothing is written unless the ONNX checker passes and torch, onnxruntime and
    NumPy agree. A log becomes a bag of ROS 2 (extra `ros2`), or a table with one row a tick: CSV,
    or Parquet (extra `parquet`).

    Examples:
      reflexarc export runs/reflex-0/checkpoint.npz -o policy.onnx
      reflexarc export ros2bag runs/drive.mcap -o runs/drive-bag
      reflexarc export parquet runs/drive.mcap -o runs/drive.parquet
      reflexarc export csv runs/drive.mcap -o runs/drive.csv
    """

    source: tyro.conf.Positional[str]
    """Checkpoint of a training run; or ros2bag, parquet or csv, followed by a log."""
    log: tyro.conf.Positional[Path | None] = None
    """The log (MCAP), behind ros2bag, parquet or csv."""
    out: Annotated[Path, tyro.conf.arg(aliases=["-o"])] = tyro.MISSING
    """The file to write; of a bag, the folder."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> int:
        """Export, and say what was written."""
        kind = self.source
        if self.log is None and kind not in EXPORTS:
            return self._export_policy()
        if self.log is None:
            raise UsageError(
                f"{kind}: expected a log behind it; a checkpoint of that name: ./{kind}"
            )
        if kind not in EXPORTS:
            raise UsageError(f"expected {', '.join(EXPORTS)} in front of a log, got {kind!r}")
        rows = export_log(kind, self.log, self.out)
        if self.json:
            print_json(rows)
        else:
            console.print(facts({name: _words(value) for name, value in rows.items()}))
        return 0

    def _export_policy(self) -> int:
        from reflexarc_runtime.policy.policy import load_policy
        from reflexarc_trainer.run.delivery import export_checkpoint

        export_checkpoint(Path(self.source), self.out)
        policy = load_policy(self.out, bounds=None)
        if self.json:
            print_json({"policy": self.out, "policy_hash": policy.policy_hash})
        else:
            console.print(facts({"policy": self.out, "hash": policy.policy_hash}))
        return 0


def _words(value: object) -> str:
    if isinstance(value, Mapping):
        return plain(", ".join(f"{name} {count}" for name, count in value.items())) or "none"
    return plain(str(value))
