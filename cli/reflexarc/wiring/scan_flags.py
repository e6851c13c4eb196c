"""The flags that say what a scanner's driver means, and how the scanner sits on the robot."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:  # a command line shall not load the senses to show their flags
    from reflexarc_runtime.sensing.mounting import Mount, Sector
    from reflexarc_runtime.sensing.range_meaning import RangeMeaning


FULL_TURN_DEG = 360.0


@dataclass(frozen=True)
class ScanFlags:
    """What the driver of a scanner means by its numbers, and how the scanner sits."""

    no_return: tuple[str, ...] = ()
    """What stands for nothing met, beside infinity: nan, zero, or a distance such as 8.19."""
    range_min: float | None = None
    """Below it things are too near to be measured, metres; by default as the driver says."""
    range_max: float | None = None
    """From it on nothing was met, metres; by default as the driver says."""
    angles: Literal["radians", "degrees"] = "radians"
    """Unit of the driver's angles."""
    mount: tuple[float, float, float] | None = None
    """Where the scanner sits: metres ahead, metres to the left, degrees to the left that it is
    turned (180: backwards); by default as the scan's pose says."""
    upside_down: bool = False
    """The scanner hangs upside down."""
    ignore_sector: tuple[tuple[float, float], ...] = ()
    """Pairs of degrees, right edge and left edge, between which the scanner sees its own robot."""

    @property
    def meaning(self) -> "RangeMeaning":
        """What the driver means by its numbers.

        Raises:
            UsageError: a flag is out of range.
        """
        from reflexarc_runtime.sensing.range_meaning import Angles, RangeMeaning

        return RangeMeaning(self.no_return, self.range_min, self.range_max, Angles(self.angles))

    @property
    def known_mount(self) -> "Mount | None":
        """How the scanner sits; None: nothing was said of it.

        Raises:
            UsageError: see `meaning`.
        """
        from reflexarc_runtime.sensing.mounting import Mount

        if self.mount is None and not self.upside_down:
            return None
        x_m, y_m, yaw_deg = self.mount or (0.0, 0.0, 0.0)
        if not all(map(math.isfinite, (x_m, y_m, yaw_deg))):
            raise UsageError(f"--mount: expected finite numbers, got {x_m:g} {y_m:g} {yaw_deg:g}")
        return Mount(x_m, y_m, math.radians(yaw_deg), self.upside_down)

    @property
    def ignored(self) -> "tuple[Sector, ...]":
        """The sectors in which the scanner sees its own robot.

        Raises:
            UsageError: see `meaning`.
        """
        from reflexarc_runtime.sensing.mounting import Sector

        for right, left in self.ignore_sector:
            if not 0.0 <= left - right <= FULL_TURN_DEG:
                raise UsageError(
                    "--ignore-sector: expected pairs of a right edge and a left edge, "
                    f"counter-clockwise, at most a turn apart, got {right:g} {left:g}"
                )
        edges = ((math.radians(right), math.radians(left)) for right, left in self.ignore_sector)
        return tuple(Sector(right, left) for right, left in edges)
