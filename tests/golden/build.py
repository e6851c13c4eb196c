"""Rebuild the golden logs: `make golden`. Deterministic, but for the names of library versions.

The real node ticks on a clock that moves by itself and hands its records to the real recorder; the
policy is a tiny network of seeded weights. Look at what changed before you commit it.
"""

import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))  # the tests' support package

from support.policies import exported  # noqa: E402  # found by the line above
from support.recordings import CONTRACT, FAULT_STALLS, drive, faults, nominal  # noqa: E402

TICKS = 300
SEED = 3
STACKED = replace(CONTRACT, retina=replace(CONTRACT.retina, frames=3))
"""The same eye, remembering two retinas."""


def build(directory: Path) -> dict[str, Counter[str]]:
    """Write both logs; returns the verdict counts of each."""
    paths = {name: directory / f"{name}.mcap" for name in ("nominal", "faults")}
    for path in paths.values():
        path.unlink(missing_ok=True)
    now, before = exported(CONTRACT, SEED, "Relu"), exported(STACKED, SEED, "Relu")
    return {
        "nominal": drive(paths["nominal"], now, nominal(TICKS), TICKS),
        "faults": drive(paths["faults"], before, faults(TICKS), TICKS, stalls=FAULT_STALLS),
    }


if __name__ == "__main__":
    for name, counts in build(HERE).items():
        print(f"{name}.mcap: {dict(counts)}")
