"""Depth from two eyes: edges found in each, matched, and triangulated.

Both eyes look ahead, eye 0 at b/2 to the left of the body's middle, eye 1 at b/2 to its right;
bearings φ are left-positive. What eye 0 sees at φ₀ and eye 1 at φ₁ lies at the depth

    Z = b / (tan φ₁ − tan φ₀)

ahead of both. An error δφ of a bearing makes an error of the depth δZ = Z² δφ / (b cos² φ). What
comes out negative was seen by swapped eyes, or is no match; it is refused.

Where an edge lies within a ray: a ray that shows the mean of its sector is partly of the one side,
partly of the other. So an edge is one step between two rays, or two steps of one sign; the middle
of the borders between these rays, weighted by the steps, is its bearing, exactly.

Matched are edges of one sign (brighter to the right, or darker), in order from the left, whose
disparity tan φ₁ − tan φ₀ lies in [0, b / Z_min]; of several the leftmost, which is the nearest.
"""

from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from reflexarc_baselines.baseline import Floats
from reflexarc_runtime.arrays import Mask

Signs: TypeAlias = npt.NDArray[np.int8]

_NO_STEP = np.float32(0.01)
"""Steps below this share of full scale are rounding."""


class EyeEdges(NamedTuple):
    """EyeEdges between the rays of one eye; slot j is between ray j and ray j + 1."""

    signs: Signs
    """1: brighter to the right; −1: darker; 0: no edge: (n, rays − 1)."""
    tangents: Floats
    """Of the bearing of each edge: (n, rays − 1)."""


class Depths(NamedTuple):
    """Depths of the edges of both eyes, in metres; NaN where there is no edge, or no match."""

    left_m: Floats
    """At the slots of eye 0: (n, rays − 1)."""
    right_m: Floats
    """At the slots of eye 1: (n, rays − 1)."""


def depth_m(left_rad: Floats, right_rad: Floats, baseline_m: float) -> Floats:
    """Depth of what eye 0 sees at `left_rad` and eye 1 at `right_rad`; negative: no match."""
    disparity: Floats = np.tan(right_rad) - np.tan(left_rad)
    return _depth_m(disparity, baseline_m)


def edges_in(brightness: Floats, fov_rad: float, contrast: float) -> EyeEdges:
    """The edges that one eye sees.

    Args:
        brightness: of each ray, 0 to 1: (n, rays).
        fov_rad: field of view of the eye.
        contrast: steps that add up to less are no edge.
    """
    rays = brightness.shape[1]
    borders_rad = (fov_rad * (0.5 - np.arange(1, rays) / rays)).astype(np.float32)
    steps = np.diff(brightness, axis=1)
    signs = np.where(np.abs(steps) > _NO_STEP, np.sign(steps), 0.0).astype(np.int8)
    is_second = _second_steps(signs)
    # Each step, and what the step behind it adds to the same edge.
    follows = np.hstack([is_second[:, 1:], np.zeros((len(steps), 1), np.bool_)])
    added = np.where(follows, np.roll(steps, -1, axis=1), np.float32(0.0))
    height = steps + added
    weighted = steps * borders_rad + added * np.roll(borders_rad, -1)
    is_edge = (signs != 0) & ~is_second & (np.abs(height) >= np.float32(contrast))
    bearings_rad = np.where(is_edge, weighted / np.where(is_edge, height, 1.0), 0.0)
    return _on_their_bright_side(np.where(is_edge, signs, 0), np.tan(bearings_rad), follows)


def match(left: EyeEdges, right: EyeEdges, baseline_m: float, nearest_m: float) -> Depths:
    """Depths of the edges that both eyes see.

    Args:
        left: edges of eye 0.
        right: edges of eye 1.
        baseline_m: distance between the eyes.
        nearest_m: Z_min: nothing is nearer.
    """
    n, slots = left.signs.shape
    rows, order = np.arange(n), np.arange(slots)
    depths = Depths(*(np.full((n, slots), np.nan, np.float32) for _ in range(2)))
    last = np.full(n, -1)
    for slot in range(slots):
        disparity = right.tangents - left.tangents[:, slot, np.newaxis]
        fits = _fits(left.signs[:, slot], right.signs, disparity, baseline_m / nearest_m)
        fits &= order > last[:, np.newaxis]
        found, at = fits.any(axis=1), fits.argmax(axis=1)
        depth = _depth_m(disparity[rows, at], baseline_m)
        depths.left_m[found, slot] = depth[found]
        depths.right_m[rows[found], at[found]] = depth[found]
        last = np.where(found, at, last)
    return depths


def _depth_m(disparity: Floats, baseline_m: float) -> Floats:
    """Of edges with a disparity tan φ₁ − tan φ₀; without one infinite."""
    with np.errstate(divide="ignore"):
        return np.float32(baseline_m) / disparity


def _second_steps(signs: Signs) -> Mask:
    """Which steps belong to the edge that the step before them began."""
    is_second = np.zeros(signs.shape, np.bool_)
    for slot in range(1, signs.shape[1]):
        is_same = (signs[:, slot] != 0) & (signs[:, slot] == signs[:, slot - 1])
        is_second[:, slot] = is_same & ~is_second[:, slot - 1]
    return is_second


def _on_their_bright_side(signs: Signs, tangents: Floats, follows: Mask) -> EyeEdges:
    """Move each edge that falls over two steps to the second: the ray between is partly bright."""
    moves = follows & (signs < 0)
    came = np.hstack([np.zeros((len(moves), 1), np.bool_), moves[:, :-1]])
    moved_signs = np.where(came, np.int8(-1), np.where(moves, np.int8(0), signs))
    moved = np.where(came, np.roll(tangents, 1, axis=1), tangents)
    return EyeEdges(moved_signs.astype(np.int8), moved.astype(np.float32))


def _fits(sign: Signs, signs: Signs, disparity: Floats, most: float) -> Mask:
    is_same = (sign[:, np.newaxis] != 0) & (signs == sign[:, np.newaxis])
    fits: Mask = is_same & (disparity >= 0.0) & (disparity <= np.float32(most))
    return fits
