"""A picture as an array of pixels, on which polygons, lines and discs of the plane are painted.

Frame of the plane: x ahead to the right of the picture, y to the left upwards, metres. What is
painted is painted at twice the size and averaged in the end, which smooths its edges.
"""

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.worlds.silhouettes import Area, Floats, Rgb, circle

Pixels: TypeAlias = npt.NDArray[np.uint8]
"""(height, width, 3)."""

_FINER = 2
_FULL = 255.0


class Raster:
    """A picture of a part of the plane.

    Args:
        area: the part; a square.
        side_px: width and height of the picture.
        ground: its colour before anything is painted.
    """

    def __init__(self, area: Area, side_px: int, ground: Rgb) -> None:
        self._side = side_px * _FINER
        self._per_m = self._side / (area.high_x_m - area.low_x_m)
        self._left_top_m = np.array([area.low_x_m, area.high_y_m])
        self._colours = np.empty((self._side, self._side, 3), np.float32)
        self._colours[:] = ground

    def polygon(self, corners_m: Floats, colour: Rgb, opacity: float = 1.0) -> None:
        """Paint a simple polygon, convex or not: (corners, 2)."""
        corners = self._pixels(corners_m)
        low = np.clip(np.floor(corners.min(axis=0)).astype(int), 0, self._side)
        high = np.clip(np.ceil(corners.max(axis=0)).astype(int), 0, self._side)
        if (low >= high).any():
            return
        x, y = (np.arange(low[k], high[k]) + 0.5 for k in range(2))
        inside = _inside(corners, x, y[:, np.newaxis])
        self._paint(self._colours[low[1] : high[1], low[0] : high[0]], inside, colour, opacity)

    def disc(self, x_m: float, y_m: float, radius_m: float, colour: Rgb) -> None:
        """Paint a disc."""
        self.polygon(circle(x_m, y_m, radius_m), colour)

    def lines(
        self, from_m: Floats, to_m: Floats, width_px: float, colour: Rgb, opacity: float = 1.0
    ) -> None:
        """Paint straight lines, (n, 2) to (n, 2); where they cross they are no darker."""
        across = np.arange(max(1, round(width_px * _FINER)), dtype=np.float64)
        across -= across.mean()
        brush = np.stack(np.meshgrid(across, across), axis=-1).reshape(-1, 1, 2)
        spots = [np.empty(0, np.int64)]
        for begin, end in zip(self._pixels(from_m), self._pixels(to_m), strict=True):
            points = 2 + int(np.abs(end - begin).max())
            along = begin + np.linspace(0.0, 1.0, points)[:, np.newaxis] * (end - begin)
            places = np.floor(along + brush).astype(np.int64).reshape(-1, 2)
            places = places[((places >= 0) & (places < self._side)).all(axis=1)]
            spots.append(places[:, 1] * self._side + places[:, 0])
        once = np.unique(np.concatenate(spots))
        self._paint(self._colours.reshape(-1, 3), once, colour, opacity)

    def pixels(self) -> Pixels:
        """The picture: (side, side, 3)."""
        fine, corners = self._colours, np.ndindex(_FINER, _FINER)
        total = sum(fine[dy::_FINER, dx::_FINER] for dy, dx in corners)
        shades: Pixels = np.rint(total * np.float32(_FULL / _FINER**2)).astype(np.uint8)
        return shades

    def _pixels(self, places_m: Floats) -> Floats:
        """Places of the plane in pixels from the picture's left top: (n, 2)."""
        places: Floats = (places_m - self._left_top_m) * (self._per_m, -self._per_m)
        return places

    @staticmethod
    def _paint(
        part: npt.NDArray[np.float32],
        where: npt.NDArray[np.bool_] | npt.NDArray[np.int64],
        colour: Rgb,
        opacity: float,
    ) -> None:
        part[where] += np.float32(opacity) * (np.array(colour, np.float32) - part[where])


def _inside(corners: Floats, x: Floats, y: Floats) -> npt.NDArray[np.bool_]:
    """Which places of a grid lie within a polygon, by the number of sides to their right."""
    inside = np.zeros((len(y), len(x)), np.bool_)
    for (x0, y0), (x1, y1) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        if y0 != y1:
            crosses = (y0 > y) != (y1 > y)
            inside ^= crosses & (x < x0 + (y - y0) * (x1 - x0) / (y1 - y0))
    return inside
