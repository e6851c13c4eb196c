import math

import numpy as np
import pytest

from reflexarc_baselines.swept_strip import Path, free_on_legs_m


def legs(path: Path, *points: tuple[float, float]) -> list[float]:
    x_m, y_m = np.array([points], np.float32).transpose(2, 0, 1)
    return [float(leg[0]) for leg in free_on_legs_m(x_m, y_m, path, 9.0)]


def test_the_corner_is_where_the_first_leg_ends() -> None:
    assert Path(math.radians(30), 2.0, 0.1).corner_m == pytest.approx((math.sqrt(3), 1.0))


def test_each_leg_is_free_until_the_nearest_point_within_half_its_width() -> None:
    """30° to the left for 2 m to (1.73, 1), then ahead: (1.299, 0.75) lies 1.5 m along the first
    leg, (2.73, 1.05) 1 m along the second; (0.87, 0) is 0.43 m beside the first."""
    path = Path(math.radians(30), 2.0, 0.1)
    free = legs(path, (1.299, 0.75), (2.732, 1.05), (0.87, 0.0))
    assert free == pytest.approx([1.5, 1.0], abs=1e-3)
    assert legs(path, (0.87, 0.0)) == pytest.approx([2.0, 9.0])


def test_what_lies_behind_a_leg_is_none_of_its_business() -> None:
    assert legs(Path(0.0, 1.0, 0.2), (-0.5, 0.0)) == [1.0, 9.0]
