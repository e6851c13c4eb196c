import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_runtime.contract.eye import BeamRule, RetinaSpec
from reflexarc_runtime.errors import ContractError
from reflexarc_runtime.sensing.retina import nearest_beam, ray_bearing_rad, shade
from reflexarc_runtime.sensing.scan import Scan, UnusableScanError
from reflexarc_runtime.sensing.scan_retina import check_scannable, retina_from_scan

HALF_CIRCLE = math.pi
LIDAR = RetinaSpec(rays=16, fov_rad=math.pi, range_m=5.0, beams=BeamRule.NEAREST_BEAM)


def scan_of(ranges: list[float], start: float = -math.pi / 2, end: float = math.pi / 2) -> Scan:
    return Scan(start, end, np.array(ranges, np.float64))


def slow_retina(scan: Scan, spec: RetinaSpec) -> list[Fraction]:
    """By the words of the definition, exactly and before rounding: search all beams."""
    values = []
    for ray in range(spec.rays):
        sector = spec.fov_rad / spec.rays
        bearing = spec.fov_rad / 2 - sector * ray - sector / 2
        angles = np.linspace(scan.start_rad, scan.end_rad, len(scan.ranges_m))
        distance = float(scan.ranges_m[int(np.argmin(np.abs(angles - bearing)))])
        seen = 0.0 < distance < spec.range_m
        values.append(255 * (1 - Fraction(distance) / Fraction(spec.range_m)) if seen else 0)
    return [Fraction(value) for value in values]


def is_rounded(value: int, exact: Fraction) -> bool:
    """Halves may go either way: floating point cannot tell 25.5 from what lies beside it."""
    return abs(value - exact) <= Fraction(1, 2) + Fraction(1, 10**9)


def test_rays_sit_at_the_centres_of_equal_sectors_leftmost_first():
    bearings = [ray_bearing_rad(ray, 4, HALF_CIRCLE) for ray in range(4)]
    assert bearings == pytest.approx([3 * math.pi / 8, math.pi / 8, -math.pi / 8, -3 * math.pi / 8])


@pytest.mark.parametrize(
    ("distance_m", "expected"),
    [(0.0, 255), (2.5, 128), (4.99, 1), (5.0, 0), (9.0, 0), (math.inf, 0), (math.nan, 0)],
)
def test_nearer_is_brighter_and_nothing_is_black(distance_m: float, expected: int):
    assert shade(1.0, distance_m, 5.0, True) == expected


def test_colour_shading_keeps_the_colour_at_any_distance():
    assert [shade(0.5, d, 5.0, False) for d in (0.1, 4.9, 5.0)] == [128, 128, 0]


@given(st.floats(0.001, 4.99), st.floats(0.001, 4.99))
def test_nearness_never_grows_with_distance(a: float, b: float):
    near, far = sorted((a, b))
    assert shade(1.0, near, 5.0, True) >= shade(1.0, far, 5.0, True)


@given(st.lists(st.floats(0.01, 10.0), min_size=33, max_size=33))
def test_a_scan_gives_what_the_definition_says(ranges: list[float]):
    scan = scan_of(ranges)
    values = retina_from_scan(scan, LIDAR).ravel().tolist()
    assert all(map(is_rounded, values, slow_retina(scan, LIDAR)))


def test_the_leftmost_ray_sees_what_is_on_the_left():
    ranges = [math.inf] * 170 + [1.0] * 11  # counter-clockwise: the last beams are on the left
    retina = retina_from_scan(scan_of(ranges), LIDAR)
    assert retina[0, 0, 0] > 0
    assert retina[0, 1:, 0].sum() == 0


def test_a_full_circle_is_read_across_its_seam():
    beams = 360
    angles = np.arange(beams) * 2 * math.pi / beams
    ranges = np.where(np.cos(angles) > 0.5, 1.0, math.inf)
    spec = RetinaSpec(rays=2, fov_rad=0.2, range_m=2.0)
    seen = retina_from_scan(Scan(0.0, float(angles[-1]), ranges), spec)
    assert seen.ravel().tolist() == [128, 128]


@pytest.mark.parametrize("beams", [8, 90, 180, 360, 720])
@pytest.mark.parametrize("rays", [2, 16, 45, 180])
def test_a_full_circle_covers_every_eye(beams: int, rays: int):
    start = 2 * math.pi / beams
    for first in (0.0, -math.pi, -math.pi / 2):
        scan = Scan(first, first + 2 * math.pi - start, np.full(beams, 1.0))
        for fov_rad in (math.pi, 2 * math.pi):
            spec = RetinaSpec(rays=rays, fov_rad=fov_rad, range_m=2.0)
            assert set(retina_from_scan(scan, spec).ravel().tolist()) == {128}


def test_up_to_a_quarter_of_the_rays_may_be_unknown():
    spec = RetinaSpec(rays=8, fov_rad=math.pi, range_m=5.0)
    ranges = np.full(8, 1.0)
    centred = math.pi / 2 - math.pi / 16
    ranges[:2] = math.nan, 0.0
    good = retina_from_scan(Scan(-centred, centred, ranges), spec)
    assert good.ravel().tolist() == [204] * 6 + [255, 255]  # what is unknown is not free
    ranges[2] = -1.0
    with pytest.raises(UnusableScanError, match="3 of 8"):
        retina_from_scan(Scan(-centred, centred, ranges), spec)


@pytest.mark.parametrize(
    "scan",
    [
        scan_of([1.0] * 90, -math.pi / 4, math.pi / 4),
        scan_of([1.0]),
        scan_of([]),
        scan_of([1.0] * 90, 1.0, -1.0),
    ],
)
def test_a_scan_that_does_not_cover_the_field_of_view_is_refused(scan: Scan):
    with pytest.raises(UnusableScanError):
        retina_from_scan(scan, LIDAR)


def test_a_scan_gives_no_second_eye_and_no_colour():
    for spec in (RetinaSpec(eyes=2, baseline_m=0.1), RetinaSpec(channels=3)):
        with pytest.raises(ContractError, match="--input retina"):
            check_scannable(spec)


def test_a_bearing_halfway_belongs_to_the_later_beam():
    assert nearest_beam(0.5, 0.0, 1.0) == 1
    assert nearest_beam(0.49, 0.0, 1.0) == 0
    assert nearest_beam(-0.5, 0.0, 1.0) == 0
