"""From distances to a retina, in single numbers: one definition for simulator, bus and replay.

These functions are plain Python. The simulator compiles these same functions and computes their
arguments to the same bits, so that a simulated eye, a real scan and a replayed one agree.
"""

import math

FULL_SCALE = 255


def ray_bearing_rad(ray: int, rays: int, fov_rad: float) -> float:
    """Bearing of a ray: rays sit at the centres of equal sectors, ray 0 is the leftmost."""
    return fov_rad * (0.5 - (ray + 0.5) / rays)


def brightness(colour: float, share: float, nearness: bool) -> float:
    """Brightness, 0 to 1, of a thing of `colour` (0 to 1) at this share of the range.

    A share of 1 or more, +inf or NaN means that nothing is within range: background, 0.
    """
    if not share < 1.0:
        return 0.0
    return colour * (1.0 - share) if nearness else colour


def value(bright: float) -> int:
    """A brightness from 0 to 1 as an 8-bit value of a retina."""
    return int(FULL_SCALE * bright + 0.5)


def shade(colour: float, distance_m: float, range_m: float, nearness: bool) -> int:
    """Value of a ray that meets something of `colour` (0 to 1) at `distance_m`."""
    return value(brightness(colour, distance_m / range_m, nearness))


def nearest_beam(bearing_rad: float, start_rad: float, step_rad: float) -> int:
    """Index of the beam nearest to a bearing, on the circle; of two equally near the later one."""
    offset_rad = (bearing_rad - start_rad + 0.5 * step_rad) % (2.0 * math.pi)
    return int(offset_rad / step_rad)
