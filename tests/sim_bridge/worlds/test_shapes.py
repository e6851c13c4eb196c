import itertools
import math

import numpy as np
import pytest

from reflexarc_runtime.errors import WorldError
from reflexarc_sim_bridge.worlds.outlines import (
    CURVE_CORNERS,
    curve_share,
    polygon_angle_rad,
    polygon_share,
)
from reflexarc_sim_bridge.worlds.shapes import LOBES, Curves, Discs, Polygons, Rectangles, Shape
from support.slow_geometry import Floats, area_m2

DRAWS = 200_000


def draws(span: tuple[float, float], seed: int) -> Floats:
    return np.random.default_rng(seed).uniform(*span, DRAWS)


def assert_mean(found: Floats, expected: float, also: float = 0.0) -> None:
    """Within four standard errors, and a share of it that is allowed besides."""
    error = float(found.std()) / math.sqrt(len(found))
    assert expected == pytest.approx(float(found.mean()), abs=4 * error + also * expected)


@pytest.mark.parametrize("turned", [(0.0, 0.0), (0.3, 0.3), (-0.5, 1.2), (0.0, math.tau)])
def test_rectangles_have_the_mean_width_of_many_that_are_drawn(turned: tuple[float, float]) -> None:
    shape = Rectangles(width_m=(0.3, 1.5), length_m=(0.2, 3.0), turned_rad=turned)
    width_m, length_m, angle = draws((0.3, 1.5), 1), draws((0.2, 3.0), 2), draws(turned, 3)
    # A turned rectangle's extent is the farthest apart that two of its corners are.
    corners = [
        (a * width_m * np.cos(angle) + b * length_m * np.sin(angle)) / 2
        for a, b in itertools.product((-1, 1), repeat=2)
    ]
    assert_mean(np.ptp(corners, axis=0), shape.mean_width_m, 1e-6)
    assert_mean(width_m * length_m, shape.mean_area_m2)
    assert shape.reach_m >= np.abs(corners).max()


def test_rectangles_turned_anyhow_are_two_over_pi_times_their_half_perimeter_wide() -> None:
    shape = Rectangles(width_m=(1.0, 1.0), length_m=(2.0, 2.0), turned_rad=(0.0, math.pi))
    assert shape.mean_width_m == pytest.approx(2.0 / math.pi * 3.0, rel=1e-6)


def test_discs_are_as_wide_as_their_diameter_and_as_large_as_pi_r_squared() -> None:
    shape, radius_m = Discs((0.15, 0.75)), draws((0.15, 0.75), 4)
    assert_mean(2 * radius_m, shape.mean_width_m)
    assert_mean(math.pi * radius_m**2, shape.mean_area_m2)


def polygon_outline(generator: np.random.Generator, shape: Polygons) -> Floats:
    """Written anew from the description: corners on a circle, every other one pulled in."""
    n = int(generator.integers(shape.corners[0], shape.corners[1], endpoint=True))
    radius_m, dent = generator.uniform(*shape.radius_m), generator.uniform(*shape.dent)
    angles = math.tau / n * (np.arange(n) + generator.uniform(0.0, 0.5, n))
    angles += generator.uniform(0.0, math.tau)
    radii_m = radius_m * np.where(np.arange(n) % 2, 1.0 - dent, 1.0)
    return np.stack([radii_m * np.cos(angles), radii_m * np.sin(angles)], axis=1)


def curve_outline(generator: np.random.Generator, shape: Curves) -> Floats:
    lobes = int(generator.integers(LOBES[0], LOBES[1], endpoint=True))
    radius_m, wave = generator.uniform(*shape.radius_m), generator.uniform(*shape.waviness)
    angles = math.tau / CURVE_CORNERS * np.arange(CURVE_CORNERS)
    radii_m = radius_m * (1.0 + wave * np.cos(lobes * angles)) / (1.0 + wave)
    angles = angles + generator.uniform(0.0, math.tau)
    return np.stack([radii_m * np.cos(angles), radii_m * np.sin(angles)], axis=1)


@pytest.mark.parametrize(
    "shape",
    [
        Polygons(),
        Polygons(corners=(3, 3)),
        Polygons(corners=(4, 9), dent=(0.1, 0.7)),
        Curves(),
        Curves(waviness=(0.0, 0.9)),
    ],
)
def test_polygons_and_curves_have_the_mean_width_and_area_of_many_that_are_drawn(
    shape: Polygons | Curves,
) -> None:
    generator, outlines = np.random.default_rng(8), []
    for _ in range(5000):
        is_curve = isinstance(shape, Curves)
        outlines.append(
            curve_outline(generator, shape) if is_curve else polygon_outline(generator, shape)
        )
    # Their own sample is of 2,000: half a percent.
    assert_mean(np.array([np.ptp(o[:, 1]) for o in outlines]), shape.mean_width_m, 0.01)
    assert_mean(np.array([area_m2(o) for o in outlines]), shape.mean_area_m2, 0.02)
    assert max(np.linalg.norm(o, axis=1).max() for o in outlines) <= shape.reach_m


def test_a_hexagon_of_even_corners_is_a_hexagon() -> None:
    corners = [(polygon_angle_rad(k, 6, 0.0), polygon_share(k, 0.0)) for k in range(6)]
    assert corners == [(pytest.approx(k * math.pi / 3), 1.0) for k in range(6)]
    assert [polygon_share(k, 0.3) for k in range(3)] == [1.0, 0.7, 1.0]


def test_jitter_never_lets_a_corner_pass_the_next() -> None:
    for corners in (3, 8, 32):
        latest = [polygon_angle_rad(k, corners, 1.0) for k in range(corners)]
        earliest = [polygon_angle_rad(k + 1, corners, 0.0) for k in range(corners)]
        assert all(late < early for late, early in zip(latest, earliest, strict=True))


def test_a_curve_without_waves_is_a_circle_and_none_leaves_its_radius() -> None:
    angles = np.linspace(0.0, math.tau, 100)
    assert {curve_share(a, 3, 0.0) for a in angles} == {1.0}
    shares = [curve_share(a, m, w) for a in angles for m in range(2, 6) for w in (0.2, 0.9)]
    assert max(shares) == pytest.approx(1.0)
    assert min(shares) == pytest.approx((1.0 - 0.9) / 1.9, abs=1e-3)


@pytest.mark.parametrize("span", [(0.0, 1.0), (2.0, 1.0), (-1.0, 1.0), (1.0, 99.0), (1.0,)])
def test_sizes_that_cannot_be_are_refused(span: tuple[float, float]) -> None:
    makers = {
        "rectangles.width_m": lambda: Rectangles(width_m=span),
        "rectangles.length_m": lambda: Rectangles(length_m=span),
        "discs.radius_m": lambda: Discs(radius_m=span),
        "polygons.radius_m": lambda: Polygons(radius_m=span),
        "curves.radius_m": lambda: Curves(radius_m=span),
    }
    for name, make in makers.items():
        with pytest.raises(WorldError, match=rf"^world\.{name}: expected .*, got "):
            make()


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda: Rectangles(turned_rad=(0.0, 7.0)), "rectangles.turned_rad"),
        (lambda: Polygons(corners=(2, 5)), "polygons.corners"),
        (lambda: Polygons(corners=(3, 33)), "polygons.corners"),
        (lambda: Polygons(dent=(0.0, 1.0)), "polygons.dent"),
        (lambda: Curves(waviness=(-0.1, 0.5)), "curves.waviness"),
        (lambda: Curves(share=math.nan), "curves.share"),
        (lambda: Discs(share=-1.0), "discs.share"),
    ],
)
def test_a_shape_that_cannot_be_names_its_field(make: type[Shape], field: str) -> None:
    with pytest.raises(WorldError, match=rf"^world\.{field}: expected .*, got "):
        make()
