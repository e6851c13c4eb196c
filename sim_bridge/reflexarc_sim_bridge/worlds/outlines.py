r"""The outline of a polygon or a closed curve, from a few random numbers.

Corner k of n lies at the angle φ_k from the centre, at the distance r(φ_k) ≤ radius:

    polygon   φ_k = 2π (k + s_k) / n with s_k in [0, ½], r = radius; with `dent` > 0 every other
              corner is pulled in to radius · (1 − dent)
    curve     φ_k = 2π k / n, r(φ) = radius · (1 + w cos(mφ)) / (1 + w), m = 2 … 5, w the waviness

Without a dent all corners lie on a circle, so the polygon is convex. With one it is a star, and a
curve with w above 1/(m² + 1) has hollows: both are concave. Every outline is star-shaped about its
centre, runs counter-clockwise and stays within its radius. The functions are plain arithmetic:
compiled for the simulator, called as they are for the mean widths.
"""

import math

MAX_CORNERS = 32
CURVE_CORNERS = 24


def polygon_angle_rad(corner: int, corners: int, jitter: float) -> float:
    """Angle of a corner; `jitter` in [0, 1) moves it by up to half of the way to the next."""
    return 2.0 * math.pi * (corner + 0.5 * jitter) / corners


def polygon_share(corner: int, dent: float) -> float:
    """Distance of a corner from the centre, as a share of the radius."""
    return 1.0 - dent if corner % 2 == 1 else 1.0


def curve_share(angle_rad: float, lobes: int, waviness: float) -> float:
    """Distance of a point of the curve from the centre, as a share of the radius."""
    return wavy_share(math.cos(lobes * angle_rad), waviness)


def wavy_share(lobe_cos: float, waviness: float) -> float:
    """Distance of a point of the curve from the centre, as a share of the radius, by cos(mφ)."""
    return (1.0 + waviness * lobe_cos) / (1.0 + waviness)
