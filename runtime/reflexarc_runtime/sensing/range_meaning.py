"""What a scanner's driver means by its numbers, where it leaves the standard (REP 117).

The standard: −inf is too near to be measured, +inf is nothing met, NaN is no measurement. Drivers
also write 0, `range_max`, a constant or NaN for nothing met.
"""

import math
from dataclasses import dataclass
from enum import StrEnum
from functools import partial

import numpy as np

from reflexarc_runtime.arrays import Mask, Ranges
from reflexarc_runtime.config.checks import require
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.sensing.scan import IGNORED_M, UnusableScanError

_NAN, _ZERO = "nan", "zero"
_ALIKE = 1e-3
"""Share of the limit by which ranges may differ that are one constant."""
_CLOSE = 1e-5
"""Relative; ranges come in single precision."""

_require = partial(require, error=UsageError)


class Angles(StrEnum):
    """In which unit a driver writes its angles."""

    RADIANS = "radians"
    DEGREES = "degrees"


@dataclass(frozen=True)
class RangeMeaning:
    """What a driver means by its numbers; by default the standard."""

    no_return: tuple[str, ...] = ()
    """What else stands for nothing met: nan, zero, or a distance in metres such as 8.19."""
    min_m: float | None = None
    """Below it something is too near to be measured; None: as the message says, else 0."""
    max_m: float | None = None
    """From it on nothing was met; None: as the message says, else without limit."""
    angles: Angles = Angles.RADIANS
    """Unit of the angles."""

    def __post_init__(self) -> None:
        for word in self.no_return:
            fits = word in (_NAN, _ZERO) or _distance_m(word) > 0.0
            _require(fits, "--no-return", "nan, zero or a distance in metres", repr(word))
        least, most = self.min_m or 0.0, math.inf if self.max_m is None else self.max_m
        _require(0.0 <= least < math.inf, "--range-min", "0 or more", least)
        _require(most > least, "--range-max", f"more than {least:g}", most)

    @property
    def constants_m(self) -> tuple[float, ...]:
        """The distances that stand for nothing met."""
        return tuple(_distance_m(w) for w in self.no_return if w not in (_NAN, _ZERO))

    def radians(self, angle: float) -> float:
        """An angle of a message."""
        return math.radians(angle) if self.angles is Angles.DEGREES else angle

    def read(self, ranges_m: Ranges, min_m: float = 0.0, max_m: float = math.inf) -> Ranges:
        """The ranges by the standard: −inf too near, +inf nothing met, NaN unknown.

        Args:
            ranges_m: as the driver wrote them, (beams,).
            min_m: the message's own limits, where it has any; what is set here goes before.
            max_m: see `min_m`.

        Raises:
            UnusableScanError: limits that leave nothing between them, or ranges that contradict
                what is said here.
        """
        least, most = self._limits(min_m, max_m)
        if not self.no_return and least <= 0.0 and most == math.inf and (ranges_m >= 0.0).all():
            return ranges_m  # as most scans on our bus are
        nothing = self._nothing(ranges_m)
        self._check(ranges_m[~nothing])
        nothing |= self._beyond(ranges_m, most)
        read = np.where(nothing, math.inf, ranges_m)
        read = np.where((read > 0.0) & (read < least), -math.inf, read)
        # A zero stays one: unknown, too, and the reason of a refusal can say what came.
        kept = (read >= 0.0) | (read == -math.inf) | (ranges_m == IGNORED_M)
        return np.where(kept, read, math.nan)

    def _limits(self, min_m: float, max_m: float) -> tuple[float, float]:
        least = min_m if self.min_m is None else _single(self.min_m)
        most = max_m if self.max_m is None else _single(self.max_m)
        if not least < math.inf:
            raise UnusableScanError(f"range_min is {least:g}; --range-min METRES says what it is")
        if not most > max(0.0, least):
            raise UnusableScanError(
                f"range_max is {most:g} with a range_min of {least:g}; --range-max METRES says "
                "what it is"
            )
        return least, most

    def _nothing(self, ranges_m: Ranges) -> Mask:
        """Which ranges stand for nothing met, beside +inf and what is beyond the limit."""
        nothing = np.zeros(ranges_m.shape, np.bool_)
        if _NAN in self.no_return:
            nothing |= np.isnan(ranges_m)
        if _ZERO in self.no_return:
            nothing |= ranges_m == 0.0
        for constant_m in self.constants_m:
            nothing |= np.isclose(ranges_m, constant_m, rtol=_CLOSE, atol=0.0)
        return nothing

    def _beyond(self, ranges_m: Ranges, most: float) -> Mask:
        """Which ranges are at the limit or beyond it, and so stand for nothing met.

        A driver's constant for nothing met is one number. Where the ranges beyond a limit of its
        own differ, it measured them, and its limit is wrong: they are what they are.
        """
        beyond: Mask = ranges_m >= most
        if self.max_m is None and most < math.inf:
            farther = np.isfinite(ranges_m) & (ranges_m > most * (1.0 + _ALIKE))
            if farther.any() and np.ptp(ranges_m[farther]) > _ALIKE * most:
                beyond &= ~farther
        return beyond

    def _check(self, measured_m: Ranges) -> None:
        """Refuse measurements beyond what is said to be the end of them."""
        finite = measured_m[np.isfinite(measured_m)]
        farthest_m = float(finite.max()) if finite.size else 0.0
        for constant_m in self.constants_m:
            if farthest_m > constant_m:
                raise UnusableScanError(
                    f"a range of {farthest_m:g} m, beyond --no-return {constant_m:g}: a thing may "
                    "then be at that distance, too"
                )
        if self.max_m is not None and farthest_m > self.max_m * (1.0 + _CLOSE):
            raise UnusableScanError(
                f"a range of {farthest_m:g} m, beyond --range-max {self.max_m:g}; if it stands for "
                f"nothing met: --no-return {farthest_m:g}"
            )


def _single(limit_m: float) -> float:
    """A limit not above what it becomes in single precision, in which ranges come."""
    return min(limit_m, float(np.float32(limit_m)))


def _distance_m(word: str) -> float:
    """The number that a word stands for; NaN if it stands for none."""
    try:
        number = float(word)
    except ValueError:
        return math.nan
    return number if math.isfinite(number) else math.nan
