"""`reflexarc render`: a world or a log as a picture or as a film."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from reflexarc.terminal.output import console, facts, kibibytes, print_json, progress_bar
from reflexarc_pictures.rendering import (
    PICTURE,
    Rendered,
    check_format,
    check_place,
    render_log,
    render_world,
)
from reflexarc_runtime.errors import UsageError

MIN_SECONDS, MAX_SECONDS = 0.5, 120.0


@dataclass(frozen=True)
class RenderCommand:
    """Draw a world, or a log of `reflexarc run --record`, as a picture or as a film.

    In a world an agent drives: the policy, or one that never steers. A picture (PNG) shows the
    stretch from above, obstacles, path, contacts and the last rays, and below what was seen over
    time. A film (GIF, or MP4 where ffmpeg is installed) goes with the agent.

    A log becomes the same film, from its poses, scenes and retinas. As a picture, a drive shows the
    obstacles that the body told of; a log with scans and poses becomes a floor plan. Below or
    beside it, over time: the retina, the Q-values and the actions.

    Examples:
      reflexarc render crossing -o crossing.png
      reflexarc render crossing -o crossing.gif --policy runs/reflex-0/policy.onnx --seed 7
      reflexarc render runs/drive.mcap -o runs/drive.png
      reflexarc render runs/drive.mcap -o runs/drive.gif --seconds 20
      reflexarc render runs/intel-drive.mcap -o runs/intel.png --kind floor --json
    """

    target: tyro.conf.Positional[str]
    """A world, by its name or its file (TOML), or a log (MCAP)."""
    out: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """What to write, PNG, GIF or MP4; a file that is there is replaced."""
    policy: Path | None = None
    """In a world: who drives; by default, an agent that never steers, with the reference eye."""
    seed: int | None = None
    """In a world: which of its endless variants, 0 by default."""
    seconds: float | None = None
    """How long a film or a drive is: 10, and for the picture of a world 20, by default."""
    kind: Literal["auto", "drive", "floor"] = "auto"
    """Picture of a log: drive, floor; or auto: a floor plan where it has scans and poses."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> int:
        """Draw, and print what was written."""
        check_format(self.out)
        check_place(self.out)
        if self.seconds is not None and not MIN_SECONDS <= self.seconds <= MAX_SECONDS:
            wanted = f"{MIN_SECONDS:g} to {MAX_SECONDS:g} s"
            raise UsageError(f"--seconds: expected {wanted}, got {self.seconds}")
        self._tell(self._log() if _is_log(self.target) else self._world())
        return 0

    def _world(self) -> Rendered:
        from reflexarc_sim_bridge.worlds.files import world_named

        if self.kind != "auto":
            raise UsageError(
                f"--kind {self.kind}: only for pictures of logs; {self.target} is none"
            )
        seed = self.seed or 0
        if not 0 <= seed < 1 << 64:
            raise UsageError(f"--seed: expected 0 to 2^64 − 1, got {seed}")
        world = world_named(self.target)
        return render_world(world, self.out, self.policy, seed, self.seconds, progress_bar)

    def _log(self) -> Rendered:
        for name in ("policy", "seed"):
            if getattr(self, name) is not None:
                raise UsageError(f"--{name}: only for worlds; {self.target} is a log")
        is_picture = self.out.suffix.lower() == PICTURE
        if is_picture and self.seconds is not None:
            raise UsageError("--seconds: the picture of a log shows all of it; leave it out")
        if not is_picture and self.kind != "auto":
            raise UsageError(f"--kind {self.kind}: only for pictures, *.png, got {self.out}")
        return render_log(Path(self.target), self.out, self.kind, self.seconds, progress_bar)

    def _tell(self, made: Rendered) -> None:
        if self.json:
            print_json(made)
            return
        what = made.kind if made.frames == 1 else f"{made.kind}, {made.frames} frames"
        console.print(facts({"picture": f"{made.picture} ({what}, {kibibytes(made.bytes)})"}))


def _is_log(target: str) -> bool:
    """Whether it is a log: it ends in .mcap, or is a file that exists and is not TOML."""
    path = Path(target)
    return path.suffix == ".mcap" or (path.suffix != ".toml" and path.is_file())
