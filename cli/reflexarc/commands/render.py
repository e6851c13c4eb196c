"""`reflexarc render`: a log as a picture."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from reflexarc.output import console, facts, kibibytes, print_json
from reflexarc_runtime.errors import UsageError


@dataclass(frozen=True)
class Render:
    """Draw a log of `reflexarc run --record`: the way from above, what the policy saw and decided.

    A drive shows the obstacles that the body told of. A log with scans and poses becomes a floor
    plan: where the beams ended, and the path in the colour of each decision. Below or beside it,
    over time: the retina, the Q-values and the actions. Without poses only these.

    Examples:
      reflexarc render runs/drive.mcap -o runs/drive.png
      reflexarc render runs/intel-drive.mcap -o runs/intel.png --kind floor
      reflexarc render runs/intel-drive.mcap -o runs/intel.png --json
    """

    log: tyro.conf.Positional[Path]
    """The log (MCAP) of `reflexarc run --record`."""
    out: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """Where to write the picture (PNG); one that is there is replaced."""
    kind: Literal["auto", "drive", "floor"] = "auto"
    """drive, floor; or auto: a floor plan where the log has scans and poses."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> int:
        """Draw, and say what became of it."""
        from reflexarc.pictures.log_picture import draw_log

        if self.out.suffix.lower() != ".png":
            raise UsageError(f"--out: expected a name that ends in .png, got {self.out}")
        kind = draw_log(self.log, self.out, self.kind)
        size = self.out.stat().st_size
        if self.json:
            print_json({"picture": self.out, "kind": kind, "bytes": size})
            return 0
        console.print(facts({"picture": f"{self.out} ({kind}, {kibibytes(size)})"}))
        return 0
