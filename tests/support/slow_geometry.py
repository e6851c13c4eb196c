"""The simulator's geometry once more, slowly and by other formulas: what the compiled one must be.

A rectangle is its four edges, each met by Cramer's rule; a disc is the smaller root of its
quadratic. Plain Python, float64, nothing shared with the simulator.
"""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Obstacle:
    """Centre and half extents; a disc has its radius in both."""

    x_m: float
    y_m: float
    half_length_m: float
    half_width_m: float
    disc: bool

    def covers(self, x_m: float, y_m: float, margin_m: float = 0.0) -> bool:
        """Whether a place lies inside, deeper than `margin_m`."""
        dx, dy = abs(x_m - self.x_m), abs(y_m - self.y_m)
        if self.disc:
            return math.hypot(dx, dy) < self.half_length_m - margin_m
        return dx < self.half_length_m - margin_m and dy < self.half_width_m - margin_m


def distance_m(obstacle: Obstacle, x_m: float, y_m: float, bearing_rad: float) -> float:
    """Length of a ray from a place up to an obstacle; infinity if it passes by."""
    if obstacle.covers(x_m, y_m):
        return 0.0
    direction = (math.cos(bearing_rad), math.sin(bearing_rad))
    if obstacle.disc:
        return _to_circle(obstacle, x_m, y_m, direction)
    left, right = obstacle.x_m - obstacle.half_length_m, obstacle.x_m + obstacle.half_length_m
    low, high = obstacle.y_m - obstacle.half_width_m, obstacle.y_m + obstacle.half_width_m
    corners = [(left, low), (right, low), (right, high), (left, high)]
    edges = zip(corners, corners[1:] + corners[:1], strict=True)
    return min(_to_edge(start, end, (x_m, y_m), direction) for start, end in edges)


def _to_edge(
    start: tuple[float, float],
    end: tuple[float, float],
    eye: tuple[float, float],
    direction: tuple[float, float],
) -> float:
    edge = (end[0] - start[0], end[1] - start[1])
    there = (start[0] - eye[0], start[1] - eye[1])
    determinant = edge[0] * direction[1] - edge[1] * direction[0]
    if abs(determinant) < 1e-15:
        return math.inf
    along_ray = (edge[0] * there[1] - edge[1] * there[0]) / determinant
    along_edge = (direction[0] * there[1] - direction[1] * there[0]) / determinant
    return along_ray if along_ray >= 0.0 and 0.0 <= along_edge <= 1.0 else math.inf


def _to_circle(obstacle: Obstacle, x_m: float, y_m: float, direction: tuple[float, float]) -> float:
    dx, dy = x_m - obstacle.x_m, y_m - obstacle.y_m
    half_b = dx * direction[0] + dy * direction[1]
    c = dx * dx + dy * dy - obstacle.half_length_m**2
    if half_b * half_b < c or half_b > 0.0:
        return math.inf
    return -half_b - math.sqrt(half_b * half_b - c)
