"""Makes a retina of the images of a camera.

The paper fills obstacles with a colour that tells them from the environment (section 4); here a
calibration says which colours those are. A ray is the mean over its sector of columns, within a
band of rows, of what is obstacle there: with one channel an obstacle's pixel is 255, with three it
is the pixel's own colour; all else is 0, as the background of the contract.

Columns u are continuous, 0 at the left edge of the image and `width` at the right one; pixel k
covers k to k + 1. Ray i looks at bearings from fov (1/2 − i/rays) to fov (1/2 − (i + 1)/rays), and
a bearing b, counter-clockwise, is seen at u = width/2 − f tan b by a pinhole, width/2 − f b by an
equidistant lens. Without a lens the columns are shared out equally.
"""

import math
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.arrays import Retina
from reflexarc_runtime.contract.eye import RetinaSpec, Shading
from reflexarc_runtime.errors import ContractError, UsageError
from reflexarc_sim_bridge.body.camera.calibration import (
    Background,
    Band,
    Calibration,
    ColourRange,
    Lens,
    Projection,
)

Image: TypeAlias = npt.NDArray[np.uint8]
"""Red, green, blue: (rows, columns, 3)."""

Floats: TypeAlias = npt.NDArray[np.float64]

_FULL = np.uint8(255)
_EDGE_TOLERANCE_RAD = 1e-9


class CameraEye:
    """Makes the retina of a contract from images.

    Args:
        calibration: of the camera.
        spec: what the policy sees.

    Raises:
        ContractError: the policy sees how near things are, which a camera cannot measure.
        UsageError: the lens does not cover the policy's field of view.
    """

    def __init__(self, calibration: Calibration, spec: RetinaSpec) -> None:
        if spec.shading is Shading.NEARNESS:
            raise ContractError(
                "a camera sees colours and no distances, the policy sees nearness; "
                "train one on colours (reflexarc train --preset paper), or give it scans"
            )
        if calibration.lens is not None:
            _check_covered(calibration.lens, spec)
        self._calibration = calibration
        self._spec = spec

    def look(self, images: tuple[Image, ...]) -> Retina:
        """The retina of one moment.

        Args:
            images: one for each eye, the left one first; or one of two eyes, side by side.
        """
        if len(images) < self._spec.eyes:
            images = _halves(images[0])
        return np.stack([self._look_with_one(image) for image in images])

    def _look_with_one(self, image: Image) -> npt.NDArray[np.uint8]:
        """One eye: (rays, channels)."""
        band = rows_of(image, self._calibration.band)
        colours = band if self._spec.channels == 3 else _FULL
        is_obstacle = obstacle_pixels(band, self._calibration.obstacle)
        profile = np.where(is_obstacle[:, :, np.newaxis], colours, 0).mean(axis=0)
        edges = sector_edges(self._spec, self._calibration.lens, image.shape[1])
        return np.floor(sector_means(profile, edges) + 0.5).astype(np.uint8)


def obstacle_pixels(image: Image, obstacle: Background | ColourRange) -> npt.NDArray[np.bool_]:
    """Which pixels belong to obstacles: (rows, columns)."""
    if isinstance(obstacle, ColourRange):
        inside = (image >= np.array(obstacle.lowest)) & (image <= np.array(obstacle.highest))
        within: npt.NDArray[np.bool_] = np.all(inside, axis=2)
        return within
    difference = image.astype(np.int32) - np.array(obstacle.colour, np.int32)
    differs: npt.NDArray[np.bool_] = np.sum(difference**2, axis=2) > obstacle.tolerance**2
    return differs


def rows_of(image: Image, band: Band) -> Image:
    """The rows whose middle lies within the band; the one nearest to its middle if none does."""
    height = image.shape[0]
    first, end = math.ceil(band.top * height - 0.5), math.ceil(band.bottom * height - 0.5)
    if first >= end:
        first = min(int((band.top + band.bottom) / 2.0 * height), height - 1)
        end = first + 1
    return image[first:end]


def sector_edges(spec: RetinaSpec, lens: Lens | None, width: int) -> Floats:
    """Columns at which the sectors of the rays begin and end, from left to right: (rays + 1,)."""
    shares = np.arange(spec.rays + 1) / spec.rays
    if lens is None:
        return shares * width
    bearings_rad = spec.fov_rad * (0.5 - shares)
    half_rad = lens.fov_rad / 2.0
    if lens.projection is Projection.EQUIDISTANT:
        offsets = bearings_rad / half_rad
    else:
        offsets = np.tan(bearings_rad) / math.tan(half_rad)
    edges: Floats = width / 2.0 * (1.0 - offsets)
    return edges


def sector_means(profile: Floats, edges: Floats) -> Floats:
    """Mean of a profile between neighbouring edges, exact for edges within a pixel.

    Args:
        profile: one value a pixel: (columns, channels).
        edges: ascending, in columns: (n + 1,).

    Returns:
        (n, channels).
    """
    columns = np.arange(len(profile) + 1)
    total = np.concatenate([np.zeros((1, profile.shape[1])), np.cumsum(profile, axis=0)])
    at_edges = np.stack([np.interp(edges, columns, channel) for channel in total.T], axis=1)
    means: Floats = np.diff(at_edges, axis=0) / np.diff(edges)[:, np.newaxis]
    return means


def _check_covered(lens: Lens, spec: RetinaSpec) -> None:
    if spec.fov_rad > lens.fov_rad + _EDGE_TOLERANCE_RAD:
        raise UsageError(
            f"lens.fov_rad: expected at least the policy's {spec.fov_rad:.3f} rad, "
            f"got {lens.fov_rad:.3f}; use a wider lens, a policy with a narrower eye, or leave "
            "[lens] out to spread the image over the whole eye"
        )


def _halves(image: Image) -> tuple[Image, Image]:
    middle = max(1, image.shape[1] // 2)
    return image[:, :middle], image[:, image.shape[1] - middle :]
