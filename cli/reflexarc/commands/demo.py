"""`reflexarc demo`: everything from learning to replay, in about a minute."""

import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from reflexarc.terminal.output import console, print_json
from reflexarc.terminal.signals import terminated_as_interrupted
from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from reflexarc.demo.results import DemoResult, LearningResult

MADE = (
    "policy.onnx",
    "drive.mcap",
    "drive.mcap.partial",
    "drive.png",
    "curve.png",
    "simulated-scans.log",
    "lidar.mcap",
    "lidar-drive.mcap",
    "lidar-drive.mcap.partial",
    "training",
)
MARK = ".made-by-reflexarc-demo"
DRIVE_SEED = 4


@dataclass(frozen=True)
class DemoCommand:
    """Learn a policy, export it, drive with it over the bus, record, replay, report.

    Examples:
      reflexarc demo
      reflexarc demo --seconds 30 --out runs/long
      reflexarc demo --lidar intel.log.gz
      reflexarc demo --json
    """

    out: Path = Path("runs/demo")
    """Folder to write to; what an earlier demo left there is replaced."""
    seconds: float = 12.0
    """How long to drive."""
    agents: int = 1024
    """Agents that measure each figure on the reference field."""
    lidar: Path | None = None
    """A real lidar's log (CARMEN or CoreSLAM); a simulated one by default."""
    json: bool = False
    """Print one JSON object in place of the screen."""

    def run(self) -> int:
        """Go through all stages; 0 only if the replay is identical."""
        if not 1.0 <= self.seconds <= 3600.0:
            raise UsageError(f"--seconds: expected 1 to 3600, got {self.seconds}")
        if self.agents < 1:
            raise UsageError(f"--agents: expected 1 or more, got {self.agents}")
        if self.lidar is not None and not self.lidar.is_file():
            raise UsageError(f"--lidar: {self.lidar}: no such file")
        _clear(self.out)
        with terminated_as_interrupted():
            return self._go()

    def _go(self) -> int:
        from reflexarc.demo import stages
        from reflexarc.demo.driving import drive
        from reflexarc.demo.lidar import drive_on_scans
        from reflexarc.demo.results import DemoResult
        from reflexarc_pictures.log_pictures.log_picture import draw_log
        from reflexarc_runtime.policy.policy import load_policy

        policy, log = self.out / "policy.onnx", self.out / "drive.mcap"
        curve, picture = self.out / "curve.png", self.out / "drive.png"
        learning = self._learn(policy, curve)
        rate_hz = load_policy(policy).contract.rate_hz
        driven = drive(policy, log, seconds=self.seconds, rate_hz=rate_hz, seed=DRIVE_SEED)
        replayed = stages.replay_log(log)
        draw_log(log, picture)
        files = {"policy": policy, "log": log, "curve": curve, "picture": picture}
        found = DemoResult(
            learning,
            driven,
            stages.look_at_log(log),
            replayed,
            drive_on_scans(policy, self.out, self.lidar),
            {name: str(path) for name, path in files.items()},
        )
        self._tell(found)
        return 0 if replayed.verdict == found.lidar.verdict == "identical" else 1

    def _learn(self, policy: Path, curve: Path) -> "LearningResult":
        """Learn, copy the policy and its learning curve, and measure what was learned."""
        from reflexarc.demo import stages
        from reflexarc.terminal.signals import StopFlag

        with StopFlag() as stop:
            result = stages.learn(self.out / "training", stop)
        if result.interrupted:
            raise KeyboardInterrupt
        shutil.copyfile(result.policy_path, policy)
        shutil.copyfile(self.out / "training" / "curve.png", curve)
        return stages.measure_learning(result, self.agents)

    def _tell(self, found: "DemoResult") -> None:
        from reflexarc.demo.screen import screen

        if self.json:
            print_json(found)
        else:
            console.print(screen(found))


def _clear(out: Path) -> None:
    """Remove the files of an earlier demo, and no others: a file in its folder marks it."""
    taken = [name for name in MADE if (out / name).exists()]
    if taken and not (out / MARK).exists():
        raise UsageError(f"--out: {out}: {taken[0]} is there and no demo made it; choose another")
    try:
        out.mkdir(parents=True, exist_ok=True)
        (out / MARK).touch()
        for name in MADE:
            made = out / name
            if made.is_dir():
                shutil.rmtree(made)
            else:
                made.unlink(missing_ok=True)
    except OSError as error:
        raise UsageError(f"--out: {out}: cannot be written: {error.strerror}") from None
