from pathlib import Path

import pytest

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.body.camera.calibration import (
    Background,
    Band,
    Calibration,
    ColourRange,
    Lens,
    Projection,
    parse_calibration,
    read_calibration,
)

WHOLE = """
[band]
top = 0.6
bottom = 1.0
[lens]
fov_rad = 2
projection = "equidistant"
[background]
colour = [200, 200, 190]
tolerance = 40.5
"""


def test_a_whole_file_is_read():
    assert parse_calibration(WHOLE) == Calibration(
        Band(0.6, 1.0), Lens(2.0, Projection.EQUIDISTANT), Background((200, 200, 190), 40.5)
    )


def test_an_empty_file_is_the_default():
    assert parse_calibration("") == Calibration()


def test_an_obstacle_may_stand_in_place_of_a_background():
    text = "[obstacle]\nlowest = [150, 0, 0]\nhighest = [255, 90, 90]"
    assert parse_calibration(text).obstacle == ColourRange((150, 0, 0), (255, 90, 90))


REFUSED: dict[str, tuple[str, str]] = {
    "no TOML": ("[band]\ntop = = 1", "line 2"),
    "unknown table": ("[ears]", "ears: unknown"),
    "unknown field": ("[band]\nleft = 1", r"band\.left: unknown"),
    "missing field": ("[obstacle]\nlowest = [1, 2, 3]", r"obstacle\.highest: missing"),
    "no table": ("band = 3", "band: expected a table"),
    "text": ('[band]\ntop = "high"', r"band\.top: expected a number"),
    "truth": ("[band]\ntop = true", r"band\.top: expected a number"),
    "NaN": ("[band]\ntop = nan", r"band\.top: expected 0 to 1"),
    "upside down": ("[band]\ntop = 0.5\nbottom = 0.4", r"band\.bottom"),
    "below the image": ("[band]\nbottom = 1.5", r"band\.bottom"),
    "no lens": ("[lens]", r"lens\.fov_rad: missing"),
    "no field": ("[lens]\nfov_rad = 0", r"lens\.fov_rad"),
    "pinhole of half a circle": ("[lens]\nfov_rad = 3.2", r"lens\.fov_rad"),
    "projection": ('[lens]\nfov_rad = 1\nprojection = "magic"', "pinhole or equidistant"),
    "projection number": ("[lens]\nfov_rad = 1\nprojection = 3", "pinhole or equidistant"),
    "two numbers": ("[background]\ncolour = [1, 2]", "three whole numbers"),
    "fractions": ("[background]\ncolour = [1, 2, 2.5]", "three whole numbers"),
    "too bright": ("[background]\ncolour = [1, 2, 256]", "three whole numbers"),
    "one number": ("[background]\ncolour = 7", "line 2: .*three whole numbers, got 7"),
    "tolerance": ("[background]\ntolerance = -1", r"background\.tolerance"),
    "swapped": ("[obstacle]\nlowest = [9, 0, 0]\nhighest = [8, 9, 9]", r"obstacle\.highest"),
    "both": ("[background]\n[obstacle]\nlowest=[0,0,0]\nhighest=[1,1,1]", "one of the two"),
}


@pytest.mark.parametrize("name", list(REFUSED))
def test_what_is_no_calibration_is_refused_by_the_name_of_the_field(name: str):
    text, reason = REFUSED[name]
    with pytest.raises(UsageError, match=reason):
        parse_calibration(text)


def test_a_file_is_named_in_every_complaint(tmp_path: Path):
    bad, noise = tmp_path / "bad.toml", tmp_path / "noise.toml"
    bad.write_text("[ears]")
    noise.write_bytes(b"\xff\xfe")
    for path in (bad, noise, tmp_path / "none.toml", tmp_path):
        with pytest.raises(UsageError, match=str(path)):
            read_calibration(path)
