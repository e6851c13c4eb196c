"""The shades of stripes, and a straight striped corridor seen by rays: in plain Python, slowly."""

import math

from reflexarc_runtime.contract.eye import RetinaSpec, Shading

MASK = (1 << 64) - 1
GAMMA = 0x9E3779B97F4A7C15
VERSION, PAINT, BLOCK = 2, 5, 64
STRIPES = int.from_bytes(b"stripes!", "big")

EDGE_M = 1e-4
"""What a ray meets is known no better, where it meets a wall at a slant: float32."""


def mixed(z: int) -> int:
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9 & MASK
    z = (z ^ (z >> 27)) * 0x94D049BB133111EB & MASK
    return z ^ (z >> 31)


def joined(key: int, part: int) -> int:
    return mixed(key ^ mixed(part * GAMMA + GAMMA & MASK))


def shade(
    seed: int, surface: int, stripe: int, low: float, high: float, *, layer: int = 0
) -> float:
    """Grey of a stripe, 0 to 1, as 8 bits hold it."""
    key = joined(joined(joined(joined(0, VERSION), seed), layer << 8), STRIPES)
    key, counter = joined(key, surface), (stripe * BLOCK + PAINT) & MASK
    share = (mixed(key + (counter + 1) * GAMMA & MASK) >> 32) / 2**32
    return int(255 * (low + (high - low) * share) + 0.5) / 255


class StripedCorridor:
    """Walls at ±half a width along x: the right one is surface 0, the left one surface 1."""

    def __init__(
        self, seed: int, width_m: float, period_m: float, speeds_mps: tuple[float, float]
    ) -> None:
        self._seed, self._half_m, self._period_m = seed, width_m / 2, period_m
        self._speeds_mps = speeds_mps

    def values(
        self, spec: RetinaSpec, x_m: float, y_m: float, heading_rad: float, time_s: float
    ) -> list[tuple[float, float]]:
        """Least and greatest value of each ray, 0 to 255: they differ only at edges of stripes."""
        count = spec.rays * spec.samples
        bearings = [spec.fov_rad * (0.5 - (k + 0.5) / count) + heading_rad for k in range(count)]
        seen = [self._seen(spec, x_m, y_m, bearing, time_s) for bearing in bearings]
        rays = [seen[k : k + spec.samples] for k in range(0, count, spec.samples)]
        return [
            (
                255 * math.fsum(low for low, _ in ray) / spec.samples,
                255 * math.fsum(high for _, high in ray) / spec.samples,
            )
            for ray in rays
        ]

    def _seen(
        self, spec: RetinaSpec, x_m: float, y_m: float, bearing_rad: float, time_s: float
    ) -> tuple[float, float]:
        ahead, left = math.cos(bearing_rad), math.sin(bearing_rad)
        wall = 1 if left > 0 else 0
        away_m = ((self._half_m if wall else -self._half_m) - y_m) / left if left else math.inf
        if away_m > spec.range_m:
            return 0.0, 0.0
        at_m = x_m + away_m * ahead - self._speeds_mps[wall] * time_s
        near = 1 - away_m / spec.range_m if spec.shading is Shading.NEARNESS else 1.0
        shades = [
            near * shade(self._seed, wall, math.floor((at_m + off) / self._period_m), 0.0, 1.0)
            for off in (-EDGE_M * (1 + away_m), 0.0, EDGE_M * (1 + away_m))
        ]
        return min(shades), max(shades)
