"""Scans in any convention and mounting against a slow picture of all beams.

    python tests/campaigns/scans.py [--scans 10000] [--seed 20]

Prints how many of each convention were seen and how many refused, as the documentation allows.
Exit status 1: one was seen wrongly, or refused without a reason; the smallest one is printed.
"""

import argparse
import sys
import time
from collections import Counter
from pathlib import Path

from hypothesis import HealthCheck, given, seed, settings

sys.path.insert(0, str(Path(__file__).parents[1]))  # the tests' support package

from support.drawn_scans import Drawn, scans
from support.scan_judge import judge


def main() -> int:
    """Judge so many scans."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--scans", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=20)
    asked, counts = parser.parse_args(), Counter[tuple[str, str]]()
    health = list(HealthCheck)

    @seed(asked.seed)
    @settings(max_examples=asked.scans, deadline=None, database=None, suppress_health_check=health)
    @given(scans())
    def campaign(drawn: Drawn) -> None:
        outcome = judge(drawn)
        counts.update((kind, outcome) for kind in ("all", *kinds(drawn)))

    begun_s = time.monotonic()
    try:
        campaign()
    except AssertionError as error:
        print(f"{error}\n{chr(10).join(getattr(error, '__notes__', []))}", file=sys.stderr)
        return 1
    print("\n".join(table(counts)))
    print(f"seed {asked.seed}, {time.monotonic() - begun_s:.0f} s", file=sys.stderr)
    return 0


def kinds(drawn: Drawn) -> list[str]:
    """The conventions that a scan is of."""
    driver, mount, spec = drawn.driver, drawn.mount, drawn.spec
    found = [
        f"wire {driver.wire}",
        f"nothing as {driver.nothing}",
        f"too near as {driver.too_near}",
        f"unknown as {driver.unknown}",
        f"limits by {driver.limits}",
        f"rule {spec.beams.value}",
    ]
    facts = {
        "degrees": driver.degrees,
        "clockwise": driver.clockwise,
        "upside down": mount.upside_down,
        "turned": mount.yaw_rad != 0.0,
        "shifted": (mount.x_m, mount.y_m) != (0.0, 0.0),
        "ignored sector": bool(drawn.ignored),
        "up to 8 beams": len(drawn.told) <= 8,
    }
    return [*found, *(name for name, holds in facts.items() if holds)]


def table(counts: Counter[tuple[str, str]]) -> list[str]:
    """One row a convention, Markdown."""
    rows = ["| scans | seen | refused | left out |", "|---|---|---|---|"]
    for kind in sorted({kind for kind, _ in counts}):
        numbers = (counts[kind, outcome] for outcome in ("seen", "refused", "left out"))
        rows.append(f"| {kind} | {' | '.join(map(str, numbers))} |")
    return rows


if __name__ == "__main__":
    sys.exit(main())
