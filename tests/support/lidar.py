"""Lidar logs: where the real ones are, and small ones written by hand."""

import gzip
import math
import os
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

DATA = Path(os.environ.get("REFLEXARC_DATA", Path(__file__).parents[3] / "shared" / "data"))
CARMEN = ("aces", "csail", "infinite-corridor", "intel", "seattle")


def carmen_file(name: str) -> Path:
    return _real(DATA / "carmen" / f"{name}.log.gz")


def coreslam_file() -> Path:
    return _real(DATA / "coreslam" / "exp2.dat.gz")


def _real(path: Path) -> Path:
    if not path.is_file():
        pytest.skip(f"{path} is not there; REFLEXARC_DATA says where the real logs are")
    return path


def flaser(
    ranges: str = "1.5 2.5 3.5",
    *,
    count: int | None = None,
    pose: str = "1 2 0.5",
    odometry: str = "4 5 0.25",
    time: str = "100.25",
) -> str:
    """One FLASER line, with its end."""
    beams = len(ranges.split()) if count is None else count
    return f"FLASER {beams} {ranges} {pose} {odometry} {time} host {time}\n"


def odom(place: str, time: str) -> str:
    """One ODOM line, with its end."""
    return f"ODOM {place} 0 0 0 {time} host {time}\n"


def coreslam(ranges_mm: list[object], time_us: object = 1_000_000, *, tail: str = " 0\n") -> str:
    """One CoreSLAM line."""
    words = [time_us, 0, 235_000, 231_000, *["0"] * 20, *ranges_mm]
    return " ".join(map(str, words)) + tail


def slow_carmen(path: Path) -> list[tuple[list[float], list[float], str]]:
    """Ranges as they stand in the file, corrected pose, and time of every scan."""
    found = []
    for line in gzip.decompress(path.read_bytes()).decode().splitlines():
        words = line.split()
        if words[:1] == ["FLASER"]:
            ranges = [float(word) for word in words[2:-9]]
            found.append((ranges, [float(word) for word in words[-9:-6]], words[-3]))
    return found


def slow_coreslam(path: Path) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.float64]]:
    """Times in microseconds (n,) and the numbers of the ranges (n, 682)."""
    table = np.loadtxt(path)  # by its name it knows gzip
    return table[:, 0].astype(np.int64), table[:, 24:706]


def slow_retinas(
    ranges_m: npt.NDArray[np.float64],
    span_rad: tuple[float, float],
    rays: int,
    fov_rad: float,
    far_m: float,
) -> npt.NDArray[np.float64]:
    """Nearness, 0 to 255 before rounding, (n, rays) of scans (n, beams), by searching all beams.

    The first and the last beam lie at the ends of the span.
    """
    beams = ranges_m.shape[1]
    angles = np.linspace(*span_rad, beams)
    sector = fov_rad / rays
    bearings = fov_rad / 2 - sector * np.arange(rays) - sector / 2
    backwards = np.abs(angles[::-1] - bearings[:, None])  # halfway belongs to the later beam
    nearest = beams - 1 - np.argmin(backwards, axis=1)
    distances = ranges_m[:, nearest]
    seen = (distances > 0) & (distances < far_m)
    bright = np.where(seen, far_m - np.where(seen, distances, far_m), 0.0) / far_m
    return 255 * np.where(np.isnan(distances), 1.0, bright)  # what is unknown is not free


CORESLAM_SPAN_RAD = math.radians(-120), math.radians(120)


def carmen_span_rad(beams: int) -> tuple[float, float]:
    """As CARMEN's own reader has it: 180 and 181 readings are a degree apart, 360 and 361 half."""
    apart_deg = 1.0 if beams < 200 else 0.5
    return math.radians(-90), math.radians(-90 + (beams - 1) * apart_deg)
