"""Angles in degrees, by hand, after the table in the toolkit's readlog.c and SICK's manual."""

import math

import pytest

from reflexarc_logs.importing.carmen_angles import LaserParams, fan_of_words
from reflexarc_logs.importing.scan_line import BrokenLineError


def degrees_of(beams: int, *params: str, laser: bytes = b"front") -> tuple[float, float, float]:
    """Right edge, left edge, and from beam to beam."""
    said = LaserParams()
    for line in params:
        said.note(f"PARAM laser_{line} nohost 0\n".encode())
    start_rad, end_rad = said.fan(beams, laser)
    right, left = math.degrees(start_rad), math.degrees(end_rad)
    return right, left, (left - right) / (beams - 1)


@pytest.mark.parametrize(
    ("beams", "right", "left", "step"),
    [
        (181, -90, 90, 1),
        (180, -90, 89, 1),
        (361, -90, 90, 0.5),
        (360, -90, 89.5, 0.5),
        (401, -50, 50, 0.25),
        (400, -50, 49.75, 0.25),
        (3, -90, 90, 90),
        (541, -90, 90, 1 / 3),
    ],
)
def test_the_number_of_ranges_tells_the_mode(beams: int, right: float, left: float, step: float):
    assert degrees_of(beams) == pytest.approx((right, left, step))


@pytest.mark.parametrize(
    ("beams", "params", "expected"),
    [
        (401, ("front_laser_resolution 0.25", "front_laser_fov 100"), (-50, 50, 0.25)),
        (400, ("front_laser_fov 100",), (-50, 49.75, 0.25)),
        (401, ("front_laser_fov 180",), (-90, 90, 0.45)),
        (361, ("front_laser_fov 3.14159", "front_laser_resolution 0.5"), (-90, 90, 0.5)),
        (180, ("front_laser_fov 180",), (-90, 89, 1)),
        (180, ("front_laser_fov 3.14159", "front_laser_resolution 1"), (-90, 89, 1)),
        (181, ("front_laser_fov 90",), (-45, 45, 0.5)),
        (541, ("front_laser_fov 270",), (-135, 135, 0.5)),
        (541, ("front_laser_fov 4.712389",), (-135, 135, 0.5)),
        (1080, ("front_laser_fov 270", "front_laser_resolution 0.25"), (-135, 134.75, 0.25)),
        (201, ("front_laser_resolution 0.5",), (-50, 50, 0.5)),
        (181, ("rear_laser_fov 100", "front_laser_fov x"), (-90, 90, 1)),
        (181, ("front_laser_fov 180", "front_laser_fov 90"), (-45, 45, 0.5)),
        (181, ("front_laser_fov 0", "front_laser_fov -90"), (-90, 90, 1)),
    ],
)  # fmt: skip
def test_what_the_file_says_stands_above_the_guess(
    beams: int, params: tuple[str, ...], expected: tuple[float, float, float]
):
    assert degrees_of(beams, *params) == pytest.approx(expected, abs=1e-4)


def test_the_rear_laser_has_its_own_parameters():
    assert degrees_of(101, "rear_laser_fov 100", laser=b"rear") == pytest.approx((-50, 50, 1))


@pytest.mark.parametrize(
    ("words", "beams", "degrees"),
    [
        (b"-1.570796 3.141593 0.017453", 181, (-90, 90)),
        (b"-1.570796 3.141593 0.017453", 180, (-90, 89)),
        (b"-1.570796 3.141593 0.008727", 361, (-90, 90)),
        (b"-2.356194 4.712389 0.004363", 1081, (-135, 135)),
        (b"-1.570796 3.141593 0.0", 5, (-90, 90)),
        (b"-0.785398 3.141593 0.0174532925", 91, (-45, 45)),  # the resolution decides
    ],
)
def test_a_present_message_says_its_angles(words: bytes, beams: int, degrees: tuple[float, float]):
    fan = fan_of_words(beams, *words.split())
    assert tuple(map(math.degrees, fan)) == pytest.approx(degrees, abs=1e-4)


@pytest.mark.parametrize(
    "words",
    [
        b"-90 180 1",
        b"-1.57 3.14 -0.017",
        b"-1.57 -3.14 0",
        b"nan 3.14 0.017",
        b"-1.57 1e999 0.017",
        b"1e300 3.14 0.017",
        b"x y z",
    ],
)
def test_angles_of_no_scanner_are_refused(words: bytes):
    with pytest.raises(BrokenLineError):
        fan_of_words(181, *words.split())
