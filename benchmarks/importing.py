"""How fast, and in how much memory, do lidar logs become logs of ours?

    python benchmarks/importing.py [--megabytes 100] [--json]

Three synthetic files a run: CARMEN scans alone; CARMEN as mappers leave it, 16 ODOM lines a scan as
in the Radish logs; CoreSLAM. Each is imported by a process of its own, whose peak of resident
memory is its own too. Megabytes of text a second of importing, start of the process left out.
Nothing is asserted.
"""

import argparse
import itertools
import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

MEGABYTE = 1_000_000
VARIANTS = 2000
"""So many that no chunk holds a scan twice, which would compress too well."""
ODOMETRY_LINES = 16


def main() -> None:
    """Write, import, print."""
    arguments = _arguments()
    if arguments.child:
        print(json.dumps(_imported(*arguments.child)))
        return
    figures: dict[str, float] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, (kind, lines) in _logs().items():
            path = Path(folder) / "log.txt"
            _write(path, lines, arguments.megabytes * MEGABYTE)
            figures |= {f"{name}, {k}": v for k, v in _in_child(kind, path).items()}
            path.unlink()
    if arguments.json:
        print(json.dumps(figures))
        return
    for name, value in figures.items():
        print(f"{name:<52}{value:>8.1f}")


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--megabytes", type=float, default=100.0, help="of text a file")
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--child", nargs=2, metavar=("FORMAT", "FILE"), help=argparse.SUPPRESS)
    return parser.parse_args()


def _logs() -> dict[str, tuple[str, list[bytes]]]:
    """Lines to repeat, by the name of the log."""
    rng = np.random.default_rng(0)
    scans = [_carmen_scan(rng) for _ in range(VARIANTS)]
    odometry = b"".join(_odometry(rng) for _ in range(ODOMETRY_LINES))
    return {
        "carmen, scans alone": ("carmen", scans),
        "carmen, 16 ODOM lines a scan": ("carmen", [odometry + scan for scan in scans]),
        "coreslam": ("coreslam", [_coreslam_scan(rng) for _ in range(VARIANTS)]),
    }


def _carmen_scan(rng: np.random.Generator) -> bytes:
    ranges = rng.uniform(0.3, 30.0, 180)
    ranges[::37] = 81.83
    x, y, heading = rng.uniform(-3.0, 3.0, 3)
    distances = " ".join(f"{r:.2f}" for r in ranges)
    pose = f"{x:.6g} {y:.6g} {heading:.6g}"
    return f"FLASER 180 {distances} {pose} {pose} 32.9068 pippo 32.9068\n".encode()


def _odometry(rng: np.random.Generator) -> bytes:
    x, y, heading = rng.uniform(-3.0, 3.0, 3)
    return f"ODOM {x:.6g} {y:.6g} {heading:.6g} 0 0 0 32.9068 pippo 32.9068\n".encode()


def _coreslam_scan(rng: np.random.Generator) -> bytes:
    ranges = rng.integers(20, 5600, 682) * rng.integers(0, 2, 682)
    return (" ".join(map(str, [0] * 24 + ranges.tolist())) + " 0\n").encode()


def _write(path: Path, lines: list[bytes], size: float) -> None:
    with path.open("wb") as file:
        for line in _until(itertools.cycle(lines), size):
            file.write(line)


def _until(lines: Iterator[bytes], size: float) -> Iterator[bytes]:
    written = 0
    while written < size:
        line = next(lines)
        written += len(line)
        yield line


def _in_child(kind: str, path: Path) -> dict[str, float]:
    command = [sys.executable, __file__, "--child", kind, str(path)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    figures: dict[str, float] = json.loads(done.stdout)
    return figures


def _imported(kind: str, file: str) -> dict[str, float]:
    from reflexarc_logs.importing.lidar_import import import_log

    path = Path(file)
    out = path.with_suffix(".mcap")
    began_s, began_cpu_s = time.perf_counter(), time.process_time()
    import_log(path, out, kind)
    seconds, cpu_s = time.perf_counter() - began_s, time.process_time() - began_cpu_s
    out.unlink()
    megabytes = path.stat().st_size / MEGABYTE
    return {
        "MB/s": megabytes / seconds,
        "MB a second of processor time": megabytes / cpu_s,
        "peak RSS, MB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / MEGABYTE,
    }


if __name__ == "__main__":
    main()
