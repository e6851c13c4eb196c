"""What C gets of the same machine: `cyclictest` of rt-tests, and its histogram read."""

import shutil
import subprocess

from reflexarc_runtime.messages.spread import Spread

MOST_US = 100_000
"""Later ones stand in an account of their own, and count as so late."""
_PATIENCE_S = 10.0


def cyclictest(rate_hz: float, seconds: float, priority: int) -> Spread | None:
    """Run it; None if it is not installed, or is refused what it asks for."""
    path = shutil.which("cyclictest")
    if path is None:
        return None
    loops = max(20, round(rate_hz * seconds))
    words = [path, "-q", "-t", "1", "-l", str(loops), "-i", str(max(1, round(1e6 / rate_hz)))]
    words += ["-h", str(MOST_US), *(["-m", "-p", str(priority)] if priority else [])]
    words += [] if priority else ["--policy", "other"]
    try:
        done = subprocess.run(
            words,
            capture_output=True,
            text=True,
            timeout=loops / rate_hz + _PATIENCE_S,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    return parse_histogram(done.stdout) if done.returncode == 0 else None


def parse_histogram(text: str) -> Spread | None:
    """Read lines `microseconds count`; those that were later are in `# Histogram Overflows`."""
    counts = []
    beyond = 0
    for line in text.splitlines():
        words = line.split()
        if len(words) == 2 and words[0].isdecimal() and words[1].isdecimal():
            counts.append((int(words[0]), int(words[1])))
        elif line.startswith("# Histogram Overflows:") and words[-1].isdecimal():
            beyond = int(words[-1])
    counts.append((MOST_US, beyond))
    total = sum(count for _, count in counts)
    if not total:
        return None
    p50, p99, p999, most = (_percentile(counts, total * q) for q in (0.5, 0.99, 0.999, 1.0))
    return Spread(total, 1000 * p50, 1000 * p99, 1000 * p999, 1000 * most)


def _percentile(counts: list[tuple[int, int]], wanted: float) -> int:
    seen = 0
    for value, count in counts:
        seen += count
        if seen >= wanted and count:
            return value
    return counts[-1][0]
