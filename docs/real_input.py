"""A reflex on real lidar logs: `make real-input DATA="path/to/intel.log.gz …"`.

Trains the preset for range scanners, decides on every scan of each log (CARMEN or CoreSLAM) over
the bus, in lockstep and on a free port, by both rules of a ray, replays what was recorded, prints
the table of `real-input.md`, and draws the first log into `figures/`. Everything else goes to
`runs/real-input/`.
"""

import dataclasses
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from reflexarc.demo.lidar import drive_on_scans
from reflexarc.demo.results import LidarResult
from reflexarc.terminal.output import aside
from reflexarc.terminal.progress import show_progress
from reflexarc_logs.reading.reader import read_log
from reflexarc_pictures.log_pictures.log_picture import draw_log
from reflexarc_runtime.contract.eye import BeamRule
from reflexarc_runtime.errors import ReflexarcError, UsageError
from reflexarc_runtime.policy.model_file import read_model, with_contract
from reflexarc_runtime.policy.policy import load_contract
from reflexarc_trainer.config.presets import preset_named
from reflexarc_trainer.run.train import train

OUT = Path("runs/real-input")
FIGURES = Path(__file__).parent / "figures"
RULES = (BeamRule.SECTOR_MINIMUM, BeamRule.NEAREST_BEAM)
MADE = ("lidar.mcap", "lidar-drive.mcap", "lidar-drive.mcap.partial")
"""What a log becomes on its way; `drive_on_scans` names them."""

AHEAD = "stay"
"""Name of the action that goes straight on."""

Decided = dict[tuple[str, BeamRule], LidarResult]


def main(files: Sequence[Path]) -> int:
    """Print the table and draw the first log; 0 only if every replay is identical."""
    try:
        _check(files)
        policy = _learn()
        eyes = {rule: _by_rule(policy, rule) for rule in RULES}
        decided = {
            (_stem(file), rule): _decide(file, eyes[rule], rule) for file in files for rule in RULES
        }
        pictures = [_draw(_stem(files[0]), rule) for rule in RULES]
    except ReflexarcError as error:
        print(f"real-input: {error}", file=sys.stderr)
        return 2
    print("\n".join(table(decided)))
    for picture in pictures:
        aside.print(f"picture: {picture}")
    return 0 if all(found.verdict == "identical" for found in decided.values()) else 1


def table(decided: Decided) -> list[str]:
    """One row for each log and rule, Markdown."""
    lines = [
        "| log | a ray takes | scans | verdict OK | straight on | as by the other rule | "
        "replay, level policy | replay, level node |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for (name, rule), found in decided.items():
        levels = " | ".join(f"{found.levels[level]} identical" for level in ("policy", "node"))
        straight, same = _shares(name, rule)
        words = (name, rule.value, found.scans, *map(_percent, (found.ok_share, straight, same)))
        lines.append(f"| {' | '.join(map(str, words))} | {levels} |")
        if found.verdict != "identical":
            lines[-1] += f" replay: {found.verdict}"
    return lines


def _percent(share: float) -> str:
    return f"{100 * share:.1f} %"


def _shares(name: str, rule: BeamRule) -> tuple[float, float]:
    """How often the policy goes straight on, and how often by the other rule it does the same."""
    mine, others = (_actions(_log_of(name, r)) for r in (rule, *(r for r in RULES if r != rule)))
    both = mine.keys() & others.keys()
    straight = np.mean([action == AHEAD for action in mine.values()])
    return float(straight), float(np.mean([mine[scan] == others[scan] for scan in both]))


def _actions(log: Path) -> dict[int, str]:
    """Number of a scan → name of the action that was decided on it."""
    read = read_log(log)
    assert read.policy is not None  # `run --record` always attaches it
    names = [action.name for action in load_contract(read.policy).actions]
    ticks = (tick.decision for tick in read.ticks())
    return {t.input.sequence: names[t.action] for t in ticks if t.q_values}


def _check(files: Sequence[Path]) -> None:
    for file in files:
        if not file.is_file():
            raise UsageError(f"{file}: no such file; DATA names lidar logs, plain or gzip")
    if not files or len({_stem(file) for file in files}) < len(files):
        raise UsageError("DATA: expected lidar logs of different names")


def _learn() -> Path:
    with show_progress() as progress:
        return train(preset_named("lidar"), OUT / "lidar", progress=progress).policy_path


def _by_rule(policy: Path, rule: BeamRule) -> Path:
    """The same network, told to look at scans by a rule."""
    contract = load_contract(policy)
    eye = dataclasses.replace(contract.retina, beams=rule)
    path = OUT / "lidar" / f"{rule.value}.onnx"
    path.write_bytes(with_contract(read_model(policy), dataclasses.replace(contract, retina=eye)))
    return path


def _decide(file: Path, policy: Path, rule: BeamRule) -> LidarResult:
    log = _log_of(_stem(file), rule)
    log.parent.mkdir(parents=True, exist_ok=True)
    for made in (*(log.parent / name for name in MADE), log):
        made.unlink(missing_ok=True)
    aside.print(f"real-input: {file}, {rule.value} …")
    found = drive_on_scans(policy, log.parent, file)
    Path(found.log).rename(log)
    return found


def _draw(name: str, rule: BeamRule) -> Path:
    suffix = "" if rule is RULES[0] else f"-{rule.value.replace('_', '-')}"
    picture = FIGURES / f"{name}{suffix}.png"
    FIGURES.mkdir(exist_ok=True)
    draw_log(_log_of(name, rule), picture)
    return picture


def _stem(file: Path) -> str:
    return file.name.partition(".")[0]


def _log_of(name: str, rule: BeamRule) -> Path:
    return OUT / name / rule.value / f"{name}-drive.mcap"


if __name__ == "__main__":
    sys.exit(main([Path(word) for word in sys.argv[1:]]))
