"""Draws a log: as a drive among known obstacles, or as a floor plan made of scans."""

from pathlib import Path
from typing import Literal, TypeAlias

from reflexarc_logs.reading.reader import Log, read_log
from reflexarc_pictures.log_pictures.decision_strips import decisions_of
from reflexarc_pictures.log_pictures.drive import draw_drive, drive_of
from reflexarc_pictures.log_pictures.floor_plan import draw_floor_plan, floor_plan_of
from reflexarc_pictures.log_pictures.logged_poses import poses_of
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.messages.topics import POSE, SCAN

Kind: TypeAlias = Literal["auto", "drive", "floor"]


def draw_log(path: Path, picture: Path, kind: Kind = "auto") -> Literal["drive", "floor"]:
    """Draw a log of `reflexarc run --record`.

    Args:
        path: the log.
        picture: PNG to write; one that is there is replaced.
        kind: drive: from above with the obstacles that the body told of; floor: a floor plan out of
            scans and poses; auto: floor where the log has both.

    Returns:
        Which kind it became.

    Raises:
        LogError: the log cannot be read, or has no ticks.
        UsageError: a floor plan is asked for and the log has no scans, or no poses.
    """
    log = read_log(path)
    decisions = decisions_of(log)
    missing = _missing_for_floor(log)
    if kind == "floor" and missing:
        raise UsageError(
            f"--kind floor: {path}: expected scans and poses, found no {' and no '.join(missing)}; "
            "leave it out, or give --kind drive"
        )
    if kind == "drive" or missing:
        draw_drive(drive_of(log, decisions), picture)
        return "drive"
    draw_floor_plan(floor_plan_of(log, decisions), picture)
    return "floor"


def _missing_for_floor(log: Log) -> list[str]:
    """The streams without which there is no floor plan."""
    has_scans = next(log.records(log.topic(SCAN.name)), None) is not None
    has_poses = has_scans and len(poses_of(log).places) > 0
    return [topic.name for topic, there in ((SCAN, has_scans), (POSE, has_poses)) if not there]
