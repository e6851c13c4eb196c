"""`reflexarc render`: a world, a cell of a suite, a log or results as a picture, film or page."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from reflexarc.terminal.output import console, facts, kibibytes, print_json, progress_bar
from reflexarc.wiring.policy_trials import BackendName, try_policy
from reflexarc_pictures.rendering import (
    PICTURE,
    DrawnPart,
    Rendered,
    check_format,
    check_place,
    check_results_format,
    render_log,
    render_results,
    render_world,
)
from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from reflexarc_sim_bridge.evaluation.protocol.contender import Contender
    from reflexarc_sim_bridge.worlds.world import WorldSource

MIN_SECONDS, MAX_SECONDS = 0.5, 120.0
MOST_FROM_S = 36_000.0
_RESULTS = ".json"
_CELL = ":"
_OF_WORLDS = "policy", "seed", "lane", "from_", "guard", "backend"
_OF_CELLS = "setting", "rate"


@dataclass(frozen=True)
class RenderCommand:
    """Draw a world, a log of `reflexarc run --record`, or results, as a picture, film or page.

    In a world an agent drives: the policy, or one that never steers. A picture (PNG) shows the
    stretch from above, obstacles, path, contacts and the last rays, and below what was seen over
    time. A film (GIF, or MP4 where ffmpeg is installed) goes with the agent. A cell of a suite is
    driven as `evaluate --suite` drives it: the same seed and lane meet the same obstacles.

    A log becomes the same film, from its poses, scenes and retinas. As a picture, a drive shows the
    obstacles that the body told of; a log with scans and poses becomes a floor plan. Below or
    beside it, over time: the retina, the Q-values and the actions.

    Results of `evaluate --suite` become a page (HTML) that shows all of them, or a picture of the
    scores. Its worst moments are those of a policy file or of a baseline; a controller that the
    results name is not run, only `evaluate` itself draws its moments.

    Examples:
      reflexarc render crossing -o crossing.png
      reflexarc render crossing -o crossing.gif --policy runs/reflex-0/policy.onnx --seed 7
      reflexarc render lite:motion/crowd -o crowd.gif --policy runs/reflex-0/policy.onnx --from 20
      reflexarc render runs/drive.mcap -o runs/drive.png
      reflexarc render runs/drive.mcap -o runs/drive.gif --seconds 20
      reflexarc render runs/intel-drive.mcap -o runs/intel.png --kind floor --json
      reflexarc render runs/evaluation-lite/results.json -o lite.html
    """

    target: tyro.conf.Positional[str]
    """A world, by its name or its file (TOML); a cell, SUITE:FAMILY/TIER; a log (MCAP); or the
    results of a suite (JSON)."""
    out: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """What to write, PNG, GIF or MP4, of results HTML or PNG; a file that is there is replaced."""
    policy: str = ""
    """In a world: who drives, an exported file, module:Class or file.py:Class; by default, an agent
    that never steers, with the reference eye."""
    seed: int | None = None
    """In a world: which of its endless variants, 0 by default."""
    lane: int | None = None
    """In a world: which of the agents that start apart in it, 0 by default."""
    from_: Annotated[float | None, tyro.conf.arg(name="from")] = None
    """In a world: begin after this many seconds of the drive."""
    seconds: float | None = None
    """How long a film or a drive is: 10, and for the picture of a world 20, by default."""
    setting: Literal["robot", "field"] | None = None
    """In a cell: the rate and the body of the contract, the default, or 10 Hz and a point."""
    rate: float | None = None
    """In a cell: decisions a second, instead of the contract's."""
    guard: bool = False
    """In a world: drive behind the guard that `reflexarc run` has."""
    backend: BackendName | None = None
    """In a world: what computes the policy, numpy by default."""
    suite: str = ""
    """Of results: the file of their suite, if it is none that is shipped."""
    kind: Literal["auto", "drive", "floor"] = "auto"
    """Picture of a log: drive, floor; or auto: a floor plan where it has scans and poses."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> int:
        """Draw, and print what was written."""
        is_results = Path(self.target).suffix == _RESULTS
        (check_results_format if is_results else check_format)(self.out)
        check_place(self.out)
        if self.seconds is not None and not MIN_SECONDS <= self.seconds <= MAX_SECONDS:
            wanted = f"{MIN_SECONDS:g} to {MAX_SECONDS:g} s"
            raise UsageError(f"--seconds: expected {wanted}, got {self.seconds}")
        if is_results:
            self._tell(self._results())
        else:
            self._tell(self._log() if _is_log(self.target) else self._world())
        return 0

    def _results(self) -> Rendered:
        self._refuse_for("worlds", *_OF_WORLDS, *_OF_CELLS)
        self._refuse_for("worlds and logs", "seconds")
        if self.kind != "auto":
            raise UsageError(f"--kind {self.kind}: only for pictures of logs")
        from reflexarc.wiring.entrants import sources_of_baselines

        shipped = sources_of_baselines()
        return render_results(Path(self.target), self.out, self.suite, progress_bar, shipped)

    def _world(self) -> Rendered:
        if self.kind != "auto":
            raise UsageError(
                f"--kind {self.kind}: only for pictures of logs; {self.target} is none"
            )
        self._refuse_for("results", "suite")
        part = self._part()
        source, contender = self._in_cell() if _CELL in self.target else self._in_world()
        return render_world(source, self.out, contender, part, progress_bar)

    def _part(self) -> DrawnPart:
        seed, lane, from_s = self.seed or 0, self.lane or 0, self.from_ or 0.0
        for name, given in (("seed", seed), ("lane", lane)):
            if not 0 <= given < 1 << 64:
                raise UsageError(f"--{name}: expected 0 to 2^64 − 1, got {given}")
        if not 0.0 <= from_s <= MOST_FROM_S:
            raise UsageError(f"--from: expected 0 to {MOST_FROM_S:g} s, got {from_s}")
        return DrawnPart(seed, lane, from_s, self.seconds)

    def _in_world(self) -> "tuple[WorldSource, Contender]":
        from reflexarc_sim_bridge.worlds.files import world_named

        self._refuse_for("cells of a suite", *_OF_CELLS)
        return world_named(self.target), self._contender()

    def _in_cell(self) -> "tuple[WorldSource, Contender]":
        from reflexarc_sim_bridge.evaluation.protocol.setting import Setting, worlds_for
        from reflexarc_sim_bridge.evaluation.protocol.suite import suite_named

        suite, _, cell = self.target.partition(_CELL)
        source, contender = suite_named(suite).cell(cell).source, self._contender()
        return worlds_for(source, contender, Setting(self.setting or "robot")), contender

    def _contender(self) -> "Contender":
        from reflexarc_sim_bridge.evaluation.protocol.contender import BLIND
        from reflexarc_sim_bridge.evaluation.protocol.entrant import Entrant

        source = self.policy or BLIND
        if self.rate is not None and not 0.1 <= self.rate <= 10_000.0:
            raise UsageError(f"--rate: expected 0.1 to 10000, got {self.rate}")
        backend = self.backend or "numpy"
        if self.policy and not Entrant(source, source).is_code:
            try_policy(self.policy, backend)
        return Entrant(source, source, self.guard, self.rate, backend).contender()

    def _refuse_for(self, what: str, *names: str) -> None:
        """Refuse flags that would change nothing."""
        for name in names:
            if getattr(self, name) not in (None, "", False):
                flag = name.rstrip("_")
                raise UsageError(f"--{flag}: only for {what}; {self.target} is none of them")

    def _log(self) -> Rendered:
        self._refuse_for("worlds", *_OF_WORLDS, *_OF_CELLS)
        self._refuse_for("results", "suite")
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
