"""How long the phases of a loop's ticks took, as a table with a small histogram in each row."""

from collections.abc import Mapping
from math import log

from rich import box
from rich.table import Table

from reflexarc.terminal.output import microseconds
from reflexarc_runtime.messages.spread import Spread

_LEAST_BITS = 10
"""Times below 1 µs share the first column: nobody waits for them."""
_TIME_WIDTH = 8
_LEVELS = ".:-=+*#"
"""From one tick to as many as the fullest power of two has; a blank is none. By the logarithm: what
is rare is what one looks for."""


def cadence_table(phases: Mapping[str, Spread]) -> Table:
    """One row a phase: percentiles, the longest, and how many ticks there were by powers of two."""
    least = max(_LEAST_BITS, min(spread.least_bits for spread in phases.values()))
    most = max(least + 1, *(each.least_bits + len(each.octaves) for each in phases.values()))
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column("phase", no_wrap=True)
    for name in ("p50", "p99", "p99.9", "max"):
        table.add_column(name, justify="right", no_wrap=True, min_width=_TIME_WIDTH)
    scale = f"{_bound(least - 1)} to {_bound(most - 1)}"
    table.add_column(scale, no_wrap=True, min_width=most - least)
    for name, each in phases.items():
        times = (each.p50_ns, each.p99_ns, each.p999_ns, each.max_ns)
        table.add_row(name, *map(microseconds, times), bars(each, least))
    return table


def bars(spread: Spread, least_bits: int) -> str:
    """One character for each power of two, from `least_bits` on; what is below is in the first."""
    below = max(0, least_bits - spread.least_bits + 1)
    counts = [sum(spread.octaves[:below]), *spread.octaves[below:]] if below else spread.octaves
    most = max(counts)
    indent = max(0, spread.least_bits - least_bits)
    return " " * indent + "".join(_level(count, most) for count in counts)


def _level(count: int, most: int) -> str:
    if not count:
        return " "
    share = log(count) / log(most) if most > 1 else 1.0
    return _LEVELS[round(share * (len(_LEVELS) - 1))]


def _bound(bits: int) -> str:
    """A power of two, in nanoseconds, as a time for people."""
    time_ns = 1 << max(bits, 0)
    if time_ns < 1000:
        return f"{time_ns} ns"
    return f"{time_ns / 1e9:.1f} s" if time_ns >= 1e9 else microseconds(time_ns)
