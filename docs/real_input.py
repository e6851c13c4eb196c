"""A reflex on real lidar logs: `make real-input DATA="path/to/intel.log.gz …"`.

Trains the preset for range scanners, decides on every scan of each CARMEN log over the bus, in
lockstep and on a free port, replays what was recorded, prints the table of `real-input.md`, and
draws the first log into `figures/`. Everything else goes to `runs/real-input/`.
"""

import sys
from collections.abc import Sequence
from pathlib import Path

from reflexarc.demo.lidar import drive_on_scans
from reflexarc.demo.results import LidarResult
from reflexarc.terminal.output import aside
from reflexarc.terminal.progress import show_progress
from reflexarc_pictures.log_pictures.log_picture import draw_log
from reflexarc_runtime.errors import ReflexarcError, UsageError
from reflexarc_trainer.config.presets import preset_named
from reflexarc_trainer.run.train import train

OUT = Path("runs/real-input")
FIGURES = Path(__file__).parent / "figures"
MADE = ("lidar.mcap", "lidar-drive.mcap", "lidar-drive.mcap.partial")
"""What a log becomes on its way; `drive_on_scans` names them."""


def main(files: Sequence[Path]) -> int:
    """Print the table and draw the first log; 0 only if every replay is identical."""
    try:
        _check(files)
        policy = _learn()
        decided = {_stem(file): _decide(file, policy) for file in files}
        picture = FIGURES / f"{_stem(files[0])}.png"
        FIGURES.mkdir(exist_ok=True)
        draw_log(_log_of(files[0]), picture)
    except ReflexarcError as error:
        print(f"real-input: {error}", file=sys.stderr)
        return 2
    print("\n".join(table(decided)))
    aside.print(f"picture: {picture}")
    return 0 if all(found.verdict == "identical" for found in decided.values()) else 1


def table(decided: dict[str, LidarResult]) -> list[str]:
    """One row a log, Markdown."""
    lines = [
        "| log | scans | ticks | verdict OK | replay, level policy | replay, level node |",
        "|---|---|---|---|---|---|",
    ]
    for name, found in decided.items():
        levels = " | ".join(f"{found.levels[level]} identical" for level in ("policy", "node"))
        share = f"{100 * found.ok_share:.1f} %"
        lines.append(f"| {name} | {found.scans} | {found.ticks} | {share} | {levels} |")
        if found.verdict != "identical":
            lines[-1] += f" replay: {found.verdict}"
    return lines


def _check(files: Sequence[Path]) -> None:
    for file in files:
        if not file.is_file():
            raise UsageError(f"{file}: no such file; DATA names CARMEN logs, plain or gzip")
    if not files or len({_stem(file) for file in files}) < len(files):
        raise UsageError("DATA: expected CARMEN logs of different names")


def _learn() -> Path:
    with show_progress() as progress:
        return train(preset_named("lidar"), OUT / "lidar", progress=progress).policy_path


def _decide(file: Path, policy: Path) -> LidarResult:
    folder = _log_of(file).parent
    folder.mkdir(parents=True, exist_ok=True)
    for made in (*(folder / name for name in MADE), _log_of(file)):
        made.unlink(missing_ok=True)
    aside.print(f"real-input: {file} …")
    found = drive_on_scans(policy, folder, file)
    Path(found.log).rename(_log_of(file))
    return found


def _stem(file: Path) -> str:
    return file.name.partition(".")[0]


def _log_of(file: Path) -> Path:
    return OUT / _stem(file) / f"{_stem(file)}-drive.mcap"


if __name__ == "__main__":
    sys.exit(main([Path(word) for word in sys.argv[1:]]))
