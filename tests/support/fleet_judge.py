"""Whether what was seen of a robot on the bus is what its own log says of the same moment.

Whoever looks at a robot sees a snapshot: after so many ticks, so many of each verdict, a rate, a
policy, who holds the lease. The log has each tick, so it says what each of them must have been
after that many ticks. Pure; logs are read in `fleet_logs`.
"""

from bisect import bisect_right
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

S = 1_000_000_000
MS = 1_000_000
_LEASE_SLACK_NS = 250 * MS
"""Two leases' time, and half of one: what was on its way counts as seen or not."""
_PERIOD_NS = S
"""A runtime says so often how it is."""
_SLACK_HZ = 1.0


@dataclass(frozen=True)
class SeenRobot:
    """What somebody saw of one runtime."""

    robot: str
    at_ns: int
    """When that was, on the machine's monotonic clock."""
    ticks: int
    rate_hz: float
    verdicts: Mapping[str, int]
    policy_hash: str
    holder: str
    """Whom the body obeyed, in hexadecimal; empty: nobody."""
    skipped: int = 0


@dataclass(frozen=True)
class LoggedRobot:
    """The same robot as its log has it."""

    robot: str
    wake_ns: Sequence[int]
    """When each tick began."""
    verdicts: Sequence[str]
    policies: Sequence[str]
    slots: Sequence[int]
    leases: Sequence[tuple[int, str]] = field(default_factory=list)
    """(when it was heard, holder) of each lease."""


def untrue(seen: SeenRobot, logged: LoggedRobot) -> list[str]:
    """What was seen and is not so, one line each."""
    count = seen.ticks
    if not 1 <= count <= len(logged.wake_ns):
        return [f"{seen.robot}: {count} ticks, its log has {len(logged.wake_ns)}"]
    counted = dict(Counter(logged.verdicts[:count]))
    least_hz, most_hz = _rates(logged.wake_ns, count)
    skipped = _skipped(logged.slots[:count])
    is_rate = least_hz - _SLACK_HZ <= seen.rate_hz <= most_hz + _SLACK_HZ
    lines = [
        (dict(seen.verdicts) != counted, f"verdicts {dict(seen.verdicts)}, logged {counted}"),
        (seen.policy_hash != logged.policies[count - 1], f"policy {seen.policy_hash[:12]}"),
        (not is_rate, f"{seen.rate_hz:.2f} Hz, logged {least_hz:.2f} to {most_hz:.2f}"),
        (seen.skipped != skipped, f"{seen.skipped} slots skipped, logged {skipped}"),
        (not _held_by(seen, logged), f"lease of {seen.holder[:8] or 'nobody'}"),
    ]
    return [f"{seen.robot} after {count} ticks: {words}" for is_wrong, words in lines if is_wrong]


def _held_by(seen: SeenRobot, logged: LoggedRobot) -> bool:
    """Whether the log knows that holder; `top` shows the first eight digits."""
    return any(name[:8] == seen.holder[:8] for name in holders(logged, seen.at_ns))


def holders(logged: LoggedRobot, at_ns: int) -> set[str]:
    """Whom the body may have been seen to obey at a moment."""
    times = [time_ns for time_ns, _ in logged.leases]
    first = max(0, bisect_right(times, at_ns - _LEASE_SLACK_NS) - 1)
    return {name for _, name in logged.leases[first : bisect_right(times, at_ns + _LEASE_SLACK_NS)]}


def _rates(wake_ns: Sequence[int], count: int) -> tuple[float, float]:
    """The least and the greatest rate, ticks a second, of any period that ended with a tick.

    A period is a second, and what its last tick was late; where it began nobody says.
    """
    last = count - 1
    late_ns = max((b - a for a, b in pairwise(wake_ns[max(0, last - 60) : count])), default=0)
    earliest_ns = wake_ns[last] - _PERIOD_NS - late_ns
    first = min(bisect_right(wake_ns, earliest_ns, 0, count), max(0, last - 1))
    latest = bisect_right(wake_ns, wake_ns[last] - _PERIOD_NS + late_ns + 40 * MS, 0, count)
    found = [
        (last - n) * S / (wake_ns[last] - wake_ns[n]) for n in range(first, min(latest + 1, last))
    ]
    return min(found, default=0.0), max(found, default=0.0)


def _skipped(slots: Sequence[int]) -> int:
    """Deadlines without a tick, up to here: a run's first slot is 1."""
    return slots[-1] - len(slots) if slots else 0


def gaps_ms(times_ns: Sequence[int]) -> list[float]:
    """Times between messages."""
    return [(b - a) / MS for a, b in pairwise(times_ns)]


def spread(values: Sequence[float]) -> dict[str, float]:
    """Median, 99th percentile and the largest."""
    ordered = sorted(values) or [0.0]
    last = len(ordered) - 1
    shares = {"p50": 0.5, "p99": 0.99, "max": 1.0}
    return {name: round(ordered[round(share * last)], 2) for name, share in shares.items()}


def seen_of_top(told: Mapping[str, Any], at_ns: int) -> list[SeenRobot]:
    """What `reflexarc top --once --json` says of each runtime that it saw.

    Args:
        told: its object.
        at_ns: when it was printed; each status had come a while before.
    """
    return [
        SeenRobot(
            robot["robot"],
            at_ns - round(one["age_s"] * 1e9),
            one["ticks"],
            one["rate_hz"],
            one["verdicts"],
            one["policy_hash"],
            next((body["holder"] for body in robot["bodies"]), ""),
            one["skipped_slots"],
        )
        for robot in told["robots"]
        for one in robot["runtimes"]
    ]
