"""What is painted has the area, the place and the colour that it should have."""

import math

import numpy as np
import pytest

from reflexarc_sim_bridge.environments.raster import Raster
from reflexarc_sim_bridge.worlds.silhouettes import Area

AREA = Area(-1.0, 1.0, 2.0, 4.0)
"""100 pixels to the metre."""
SIDE = 200
BLACK, WHITE, RED = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0), (1.0, 0.0, 0.0)


def painted_m2(raster: Raster) -> float:
    return float(raster.pixels()[:, :, 0].sum()) / 255.0 / 100.0**2


def test_a_disc_has_its_area_and_lies_up_left_of_the_middle() -> None:
    raster = Raster(AREA, SIDE, BLACK)
    raster.disc(-0.5, 3.5, 0.2, WHITE)
    assert painted_m2(raster) == pytest.approx(math.pi * 0.2**2, rel=0.01)
    rows, columns = np.nonzero(raster.pixels()[:, :, 0])
    assert (rows.mean(), columns.mean()) == pytest.approx((49.5, 49.5), abs=0.5)


def test_a_polygon_with_a_notch_is_not_filled_up() -> None:
    """A square of 1 m² from which a triangle of 0.25 m² is cut."""
    corners = np.array([(-0.5, 2.5), (0.5, 2.5), (0.5, 3.5), (0.0, 3.0), (-0.5, 3.5)])
    raster = Raster(AREA, SIDE, BLACK)
    raster.polygon(corners, WHITE)
    assert painted_m2(raster) == pytest.approx(0.75, rel=0.01)
    again = Raster(AREA, SIDE, BLACK)
    again.polygon(corners[::-1], WHITE)
    np.testing.assert_array_equal(raster.pixels(), again.pixels())


def test_what_reaches_out_of_the_picture_is_cut_and_what_lies_outside_is_not_there() -> None:
    raster = Raster(AREA, SIDE, BLACK)
    raster.polygon(np.array([(0.5, 3.5), (9.0, 3.5), (9.0, 9.0), (0.5, 9.0)]), WHITE)
    assert painted_m2(raster) == pytest.approx(0.25, rel=0.01)
    raster.disc(5.0, 3.0, 1.0, WHITE)
    raster.disc(0.0, -9.0, 1.0, WHITE)
    assert painted_m2(raster) == pytest.approx(0.25, rel=0.01)


def test_lines_that_cross_are_no_darker_there_and_end_where_they_should() -> None:
    raster = Raster(AREA, SIDE, WHITE)
    begins, ends = np.array([(-0.5, 3.0), (0.0, 2.5)]), np.array([(0.5, 3.0), (0.0, 3.5)])
    raster.lines(begins, ends, 2.0, BLACK, 0.5)
    shades = np.unique(raster.pixels())
    assert shades.min() == 128
    rows, columns = np.nonzero(raster.pixels()[:, :, 0] < 255)
    assert (rows.min(), rows.max()) == pytest.approx((50, 149), abs=1.5)
    assert (columns.min(), columns.max()) == pytest.approx((50, 149), abs=1.5)
    raster.lines(np.empty((0, 2)), np.empty((0, 2)), 1.0, RED)
    raster.lines(np.array([(8.0, 8.0)]), np.array([(9.0, 9.0)]), 1.0, RED)
    assert (raster.pixels()[:, :, 0] == raster.pixels()[:, :, 1]).all()
