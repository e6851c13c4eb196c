"""Numbers of a world that are drawn anew for each seed: domain randomisation.

In a world file `{ from = 0.2, to = 0.6 }` may stand in place of any number. Every seed draws its
own, uniformly, both ends included; whole numbers where the field is one. A draw is a hash of the
seed and of the place of the number in the file: adding a range changes no other.
"""

import hashlib
import sys
from collections.abc import Callable
from typing import TypeAlias

from reflexarc_runtime.config.fill import Resolve
from reflexarc_runtime.config.key_path import KeyPath, dotted
from reflexarc_sim_bridge.worlds.checks import Span

Choose: TypeAlias = Callable[[Span, type, KeyPath], float]
"""One number of a range: (its ends, int or float, where it stands) → the number."""

WIDTH = "width_m"
"""Where the width of a world stands in its file."""

_SMALL_IS_MORE = ("period_s", "wavelength_m")
"""Fields by which things are the faster or the steeper, the smaller they are."""
_LARGEST = sys.float_info.max
_SALT = "reflexarc world range 1"
"""Any change to what a seed draws takes a new number."""
_STEPS = (1 << 53) - 1


def resolving(choose: Choose) -> Resolve:
    """Read numbers as they are, and ranges as one number that `choose` takes of each."""

    def resolve(value: object, kind: type, path: KeyPath) -> object:
        if not isinstance(value, dict):
            return value
        return choose(_ends(value, kind), kind, path)

    return resolve


def lowest(ends: Span, kind: type, path: KeyPath) -> float:
    """Take the lower end of a range."""
    return ends[0]


def highest(ends: Span, kind: type, path: KeyPath) -> float:
    """Take the upper end of a range."""
    return ends[1]


def farthest(ends: Span, kind: type, path: KeyPath) -> float:
    """Take the end that needs more memory: what makes obstacles large, many, fast or steep."""
    return ends[0] if path[-1] in _SMALL_IS_MORE else max(ends, key=abs)


def farthest_at(width_m: float) -> Choose:
    """Take the ends that need more memory, but for the width of the world, which is given."""

    def choose(ends: Span, kind: type, path: KeyPath) -> float:
        return width_m if dotted(path) == WIDTH else farthest(ends, kind, path)

    return choose


def narrowest(ends: Span, kind: type, path: KeyPath) -> float:
    """Take the upper end of a span's lower bound, and the lower end of any other range."""
    return ends[1] if path[-1] == 0 else ends[0]


def drawn(seed: int) -> Choose:
    """Take the number that a seed draws from a range."""

    def draw(ends: Span, kind: type, path: KeyPath) -> float:
        digest = hashlib.sha256(f"{_SALT}:{seed}:{dotted(path)}".encode()).digest()
        bits = int.from_bytes(digest[:8], "big") >> 11
        if kind is int:
            low, high = int(ends[0]), int(ends[1])
            return low + (bits * (high - low + 1) >> 53)
        return min(ends[0] + (ends[1] - ends[0]) * (bits / _STEPS), ends[1])

    return draw


def _ends(table: dict[str, object], kind: type) -> Span:
    """The ends of a range.

    Raises:
        ValueError: it is none.
    """
    noun = "whole numbers" if kind is int else "numbers"
    low, high = (_end(table.get(name), kind) for name in ("from", "to"))
    if low is None or high is None or len(table) != 2 or low > high:
        raise ValueError(f"expected a range {{ from = low, to = high }} of {noun}, got another")
    return low, high


def _end(value: object, kind: type) -> float | None:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    if kind is int and not isinstance(value, int):
        return None
    return value if abs(value) <= _LARGEST else None
