import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_runtime.contract.eye import RetinaSpec, Shading
from reflexarc_runtime.errors import ContractError, UsageError
from reflexarc_runtime.sensing.ray_values import ray_bearing_rad
from reflexarc_sim_bridge.body.camera.calibration import (
    Background,
    Band,
    Calibration,
    ColourRange,
    Lens,
    Projection,
)
from reflexarc_sim_bridge.body.camera.eye import (
    CameraEye,
    Image,
    rows_of,
    sector_edges,
    sector_means,
)

WIDE = RetinaSpec(rays=16, fov_rad=math.pi / 2, shading=Shading.COLOUR)
RED = (200, 30, 20)


def seen(calibration: Calibration, spec: RetinaSpec, *images: Image) -> list[int]:
    retina = CameraEye(calibration, spec).look(images)
    assert retina.shape == spec.shape
    assert retina.dtype == np.uint8
    return retina[0, :, 0].tolist()


def room(width: int = 640, height: int = 40, colour: tuple[int, int, int] = (0, 0, 0)) -> Image:
    return np.full((height, width, 3), colour, np.uint8)


def with_bar(image: Image, first: int, end: int, colour: tuple[int, int, int] = RED) -> Image:
    image[:, first:end] = colour
    return image


def test_an_empty_room_is_dark_and_a_wall_is_bright():
    assert seen(Calibration(), WIDE, room()) == [0] * 16
    assert seen(Calibration(), WIDE, room(colour=RED)) == [255] * 16


def test_without_a_lens_equal_shares_of_the_columns_are_the_rays():
    # 640 columns on 16 rays: 40 each; a bar over columns 80 to 140 is rays 2, 3 and half: none.
    assert seen(Calibration(), WIDE, with_bar(room(), 80, 140)) == [0, 0, 255, 128] + [0] * 12


def pinhole_column(bearing_rad: float, fov_rad: float, width: int) -> float:
    """Where the ray through the image plane at distance 1 meets a pixel: by similar triangles."""
    half_plane = math.tan(fov_rad / 2)
    return (half_plane - math.tan(bearing_rad)) / (2 * half_plane) * width


@given(
    st.integers(1, 24), st.floats(0.3, 2.6), st.floats(0.2, 1.0), st.integers(0, 23), st.booleans()
)
def test_a_bar_over_the_sector_of_a_ray_lights_that_ray(
    rays: int, lens_rad: float, share: float, ray: int, pinhole: bool
):
    ray %= rays
    spec = RetinaSpec(rays=rays, fov_rad=lens_rad * share, shading=Shading.COLOUR)
    projection = Projection.PINHOLE if pinhole else Projection.EQUIDISTANT
    half_sector_rad = spec.fov_rad / rays / 2
    middle_rad = ray_bearing_rad(ray, rays, spec.fov_rad)
    width = 20_000
    left, right = (
        pinhole_column(bearing_rad, lens_rad, width)
        if pinhole
        else (0.5 - bearing_rad / lens_rad) * width
        for bearing_rad in (middle_rad + half_sector_rad, middle_rad - half_sector_rad)
    )
    image = with_bar(room(width, 4), round(left), round(right))
    values = seen(Calibration(lens=Lens(lens_rad, projection)), spec, image)
    # A column at each end may be rounded to the neighbour.
    slack = math.ceil(255 / (right - left)) + 1
    assert values[ray] >= 255 - 2 * slack
    assert all(value <= slack for other, value in enumerate(values) if other != ray)


def test_a_post_at_a_known_bearing_lights_the_ray_that_looks_there():
    # 0.3 rad to the left; sectors of 90° / 16 = 0.098 rad: ray 4 looks from 0.393 to 0.295 rad.
    column = pinhole_column(0.3, 2.0, 640)
    image = with_bar(room(), round(column) - 1, round(column) + 1)
    values = seen(Calibration(lens=Lens(2.0)), WIDE, image)
    assert np.flatnonzero(values).tolist() == [4]


def test_left_in_the_image_is_left_on_the_retina():
    for lens in (None, Lens(WIDE.fov_rad), Lens(WIDE.fov_rad, Projection.EQUIDISTANT)):
        left, right = with_bar(room(), 0, 40), with_bar(room(), 600, 640)
        assert np.argmax(seen(Calibration(lens=lens), WIDE, left)) == 0
        assert np.argmax(seen(Calibration(lens=lens), WIDE, right)) == 15


@given(
    st.lists(st.floats(0, 255), min_size=1, max_size=30),
    st.lists(st.floats(0, 1), min_size=2, max_size=8, unique=True),
)
def test_sector_means_are_integrals(values: list[float], shares: list[float]):
    edges = np.array(sorted(shares)) * len(values)
    if np.diff(edges).min() < 1e-6:
        return
    got = sector_means(np.array(values)[:, np.newaxis], edges)[:, 0]
    for mean, begin, end in zip(got, edges, edges[1:], strict=False):
        overlap = (
            max(0.0, min(end, k + 1) - max(begin, k)) * value for k, value in enumerate(values)
        )
        assert mean == pytest.approx(sum(overlap) / (end - begin), abs=1e-6)


def test_sectors_of_a_lens_lie_within_the_image_and_do_not_overlap():
    for projection in Projection:
        edges = sector_edges(WIDE, Lens(math.pi / 2, projection), 640)
        assert (edges[0], edges[-1]) == (pytest.approx(0), pytest.approx(640))
        assert np.all(np.diff(edges) > 0)
    assert sector_edges(WIDE, Lens(2.0, Projection.EQUIDISTANT), 640)[8] == 320


def test_only_the_band_counts():
    image = room(height=100)
    image[:50] = RED
    assert seen(Calibration(band=Band(0.5, 1.0)), WIDE, image) == [0] * 16
    assert seen(Calibration(band=Band(0.25, 0.75)), WIDE, image) == [128] * 16


@pytest.mark.parametrize(
    ("height", "top", "bottom", "expected"),
    [(100, 0.45, 0.55, range(45, 55)), (10, 0.5, 0.51, [5]), (1, 0.0, 1.0, [0]), (3, 1, 1, [2])],
)
def test_a_band_is_the_rows_whose_middle_it_holds_and_never_empty(
    height: int, top: float, bottom: float, expected: list[int]
):
    rows = np.arange(height, dtype=np.uint8)[:, np.newaxis, np.newaxis]
    band = Band(top, bottom) if top < bottom else Band(0.999, 1.0)
    assert rows_of(rows, band).ravel().tolist() == list(expected)


def test_what_is_near_the_background_is_no_obstacle():
    grey = Calibration(obstacle=Background((100, 100, 100), 5.0))
    assert seen(grey, WIDE, room(colour=(103, 104, 100))) == [0] * 16  # 5 away: 3, 4, 0
    assert seen(grey, WIDE, room(colour=(103, 104, 101))) == [255] * 16
    assert seen(grey, WIDE, room(colour=(0, 0, 0))) == [255] * 16


def test_what_lies_between_two_colours_is_an_obstacle():
    red = Calibration(obstacle=ColourRange((150, 0, 0), (255, 90, 90)))
    assert seen(red, WIDE, room(colour=(150, 90, 0))) == [255] * 16
    assert seen(red, WIDE, room(colour=(149, 0, 0))) == [0] * 16
    assert seen(red, WIDE, room(colour=(255, 91, 0))) == [0] * 16


def test_three_channels_show_the_obstacles_own_colour():
    spec = RetinaSpec(rays=2, shading=Shading.COLOUR, channels=3)
    retina = CameraEye(Calibration(), spec).look((with_bar(room(), 0, 160),))
    half = [math.floor(value / 2 + 0.5) for value in RED]
    assert retina.tolist() == [[half, [0, 0, 0]]]


def test_two_eyes_are_two_images_or_the_halves_of_one():
    spec = RetinaSpec(rays=2, shading=Shading.COLOUR, eyes=2, baseline_m=0.1)
    left, right = with_bar(room(100), 0, 50), with_bar(room(100), 50, 100)
    eye = CameraEye(Calibration(), spec)
    apart = eye.look((left, right))
    assert apart[:, :, 0].tolist() == [[255, 0], [0, 255]]
    assert np.array_equal(eye.look((np.concatenate([left, right], axis=1),)), apart)
    odd = np.concatenate([left, room(1), right], axis=1)
    assert np.array_equal(eye.look((odd,)), apart)


def test_a_policy_that_sees_nearness_is_refused():
    with pytest.raises(ContractError, match="--preset paper"):
        CameraEye(Calibration(), RetinaSpec())


def test_a_lens_that_is_narrower_than_the_eye_is_refused():
    with pytest.raises(UsageError, match=r"lens.fov_rad.*1.571.*1.000"):
        CameraEye(Calibration(lens=Lens(1.0)), WIDE)
    CameraEye(Calibration(lens=Lens(math.pi / 2)), WIDE)
