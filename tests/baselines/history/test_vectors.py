import math

import numpy as np
import pytest

from reflexarc_baselines.history.vectors import Vectors, pointing, pulled


def vector(ahead: float, left: float) -> Vectors:
    return Vectors(np.array([ahead], np.float32), np.array([left], np.float32))


def test_headings_grow_to_the_left() -> None:
    assert vector(1.0, 1.0).headings_rad[0] == pytest.approx(math.pi / 4)
    assert vector(1.0, -1.0).headings_rad[0] == pytest.approx(-math.pi / 4)


@pytest.mark.parametrize("left", [0.0, -0.0])
def test_a_wish_straight_back_is_one_to_the_left_whatever_the_sign_of_zero(left: float) -> None:
    assert vector(-1.0, left).headings_rad[0] == pytest.approx(math.pi)


def test_no_wish_has_no_heading() -> None:
    assert vector(0.0, 0.0).headings_rad[0] == 0.0


def test_pulls_add_up_along_the_rays() -> None:
    """3 to the left and −2 (a push) from ahead: (−2, 3)."""
    bearings = np.array([math.pi / 2, 0.0], np.float32)
    sum_of = pulled(np.array([[3.0, -2.0]], np.float32), bearings)
    assert (sum_of.ahead[0], sum_of.left[0]) == pytest.approx((-2.0, 3.0), abs=1e-6)


def test_pointing_is_the_inverse_of_headings() -> None:
    angles = np.linspace(-3.1, 3.1, 50).astype(np.float32)
    np.testing.assert_allclose(pointing(angles).headings_rad, angles, atol=1e-6)
    np.testing.assert_allclose(pointing(angles).lengths, 1.0, atol=1e-6)
