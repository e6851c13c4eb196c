"""The simulator's geometry once more, slowly and by other formulas: what the compiled one must be.

A polygon is its edges, each met by Cramer's rule; a disc is the smaller root of its quadratic; a
place is inside a polygon whose edges a line from it crosses an odd number of times. NumPy in
float64, over all edges and all rays; nothing is shared with the simulator.
"""

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.simulation.scene import Outline

Floats = npt.NDArray[np.float64]

WHITE = (1.0, 1.0, 1.0)


def disc(x_m: float, y_m: float, radius_m: float, colour: tuple[float, ...] = WHITE) -> Outline:
    return Outline(x_m, y_m, radius_m, np.empty((0, 2)), False, (*colour[:3],), 0)


def box(
    x_m: float,
    y_m: float,
    half_length_m: float,
    half_width_m: float,
    colour: tuple[float, ...] = WHITE,
    turned_rad: float = 0.0,
) -> Outline:
    signs = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)], np.float64)
    cos, sin = math.cos(turned_rad), math.sin(turned_rad)
    turned = np.array([(cos, sin), (-sin, cos)])
    corners_m = np.array([x_m, y_m]) + signs * (half_length_m, half_width_m) @ turned
    return Outline(x_m, y_m, 0.0, corners_m, True, (*colour[:3],), 0)


def polygon(corners_m: Floats, colour: tuple[float, ...] = WHITE) -> Outline:
    """Corners counter-clockwise."""
    x_m, y_m = corners_m.mean(axis=0).tolist()
    return Outline(x_m, y_m, 0.0, corners_m, False, (*colour[:3],), 0)


def star(
    x_m: float,
    y_m: float,
    radius_m: float,
    corners: int,
    dent: float,
    turned_rad: float,
    colour: tuple[float, ...] = WHITE,
) -> Outline:
    angles = turned_rad + math.tau * np.arange(corners) / corners
    radii_m = radius_m * np.where(np.arange(corners) % 2 == 1, 1.0 - dent, 1.0)
    corners_m = np.stack([x_m + radii_m * np.cos(angles), y_m + radii_m * np.sin(angles)], axis=1)
    return polygon(corners_m, colour)


def ray_lengths_m(outlines: Sequence[Outline], eye_m: Floats, bearings_rad: Floats) -> Floats:
    """Length of each ray up to each outline, infinity past it, 0 inside: (outlines, rays)."""
    directions = np.stack([np.cos(bearings_rad), np.sin(bearings_rad)], axis=1)
    lengths = [_rays_to(outline, eye_m, directions) for outline in outlines]
    return np.array(lengths).reshape(len(outlines), len(bearings_rad))


def clearances_m(outlines: Sequence[Outline], places_m: Floats) -> Floats:
    """Distance of each place (n, 2) from each outline, below 0 inside: (outlines, n)."""
    rows = [_clearance_m(outline, places_m) for outline in outlines]
    return np.array(rows).reshape(len(outlines), len(places_m))


def moved(outline: Outline, ahead_m: float, left_m: float) -> Outline:
    return Outline(
        outline.x_m + ahead_m,
        outline.y_m + left_m,
        outline.radius_m,
        outline.corners_m + np.array([ahead_m, left_m]),
        outline.is_box,
        outline.colour,
        outline.layer,
    )


def mirrored(outline: Outline, about_y_m: float) -> Outline:
    """On the other side of a line along x; its corners still go counter-clockwise."""
    corners_m = outline.corners_m[::-1] * (1.0, -1.0) + (0.0, 2 * about_y_m)
    y_m = 2 * about_y_m - outline.y_m
    return Outline(
        outline.x_m, y_m, outline.radius_m, corners_m, outline.is_box, outline.colour, outline.layer
    )


def area_m2(corners_m: Floats) -> float:
    """Of a polygon that is star-shaped about the origin: the triangles that its edges span."""
    following = np.roll(corners_m, -1, axis=0)
    lengths = np.linalg.norm(corners_m, axis=1) * np.linalg.norm(following, axis=1)
    angles = np.arctan2(following[:, 1], following[:, 0]) - np.arctan2(
        corners_m[:, 1], corners_m[:, 0]
    )
    return float((lengths * np.sin(angles)).sum() / 2)


def _rays_to(outline: Outline, eye_m: Floats, directions: Floats) -> Floats:
    if outline.is_disc:
        return _rays_to_circle(outline, eye_m, directions)
    if _is_inside(outline.corners_m, eye_m[np.newaxis])[0]:
        return np.zeros(len(directions))
    starts = outline.corners_m[:, np.newaxis]
    edges = np.roll(outline.corners_m, -1, axis=0)[:, np.newaxis] - starts
    there = starts - eye_m
    with np.errstate(divide="ignore", invalid="ignore"):
        determinant = _cross(edges, directions)
        along_ray = _cross(edges, there) / determinant
        along_edge = _cross(directions, there) / determinant
        met = (along_ray >= 0.0) & (along_edge >= 0.0) & (along_edge <= 1.0)
    return np.where(met, along_ray, math.inf).min(axis=0)


def _rays_to_circle(outline: Outline, eye_m: Floats, directions: Floats) -> Floats:
    off_m = eye_m - (outline.x_m, outline.y_m)
    half_b, c = directions @ off_m, off_m @ off_m - outline.radius_m**2
    if c < 0.0:
        return np.zeros(len(directions))
    roots = np.sqrt(np.maximum(half_b**2 - c, 0.0))
    return np.where((half_b**2 >= c) & (half_b <= 0.0), -half_b - roots, math.inf)


def _clearance_m(outline: Outline, places_m: Floats) -> Floats:
    if outline.is_disc:
        return np.hypot(*(places_m - (outline.x_m, outline.y_m)).T) - outline.radius_m
    starts = outline.corners_m[:, np.newaxis]
    edges = np.roll(outline.corners_m, -1, axis=0)[:, np.newaxis] - starts
    squared = np.maximum((edges**2).sum(axis=-1), 1e-300)
    along = np.clip(((places_m - starts) * edges).sum(axis=-1) / squared, 0.0, 1.0)
    nearest = starts + along[..., np.newaxis] * edges
    distance_m = np.linalg.norm(places_m - nearest, axis=-1).min(axis=0)
    return np.where(_is_inside(outline.corners_m, places_m), -distance_m, distance_m)


def _is_inside(corners_m: Floats, places_m: Floats) -> npt.NDArray[np.bool_]:
    """How often a line along x from each place crosses the outline."""
    (x, y), (end_x, end_y) = (
        corners_m.T[..., np.newaxis],
        np.roll(corners_m, -1, 0).T[..., np.newaxis],
    )
    at_x, at_y = places_m.T
    spans = (y <= at_y) != (end_y <= at_y)
    with np.errstate(divide="ignore", invalid="ignore"):
        crosses_x = x + (at_y - y) / (end_y - y) * (end_x - x)
        crossings = (spans & (crosses_x > at_x)).sum(axis=0)
    return crossings % 2 == 1


def _cross(a: Floats, b: Floats) -> Floats:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
