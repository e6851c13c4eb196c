import re

import pytest

from reflexarc_pictures.suite_page.style import style

SHADE = re.compile(r"\.([hm]\d+)\{background:rgb\((\d+),(\d+),(\d+)\);color:#(\w{6})\}")
READABLE = 4.5
"""Contrast that WCAG 2.1 asks of small text (success criterion 1.4.3)."""


def luminance(red: int, green: int, blue: int) -> float:
    """WCAG 2.1, relative luminance."""
    linear = [
        part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4
        for part in (red / 255, green / 255, blue / 255)
    ]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one: float, other: float) -> float:
    return (max(one, other) + 0.05) / (min(one, other) + 0.05)


def shades(sheet: str) -> dict[str, tuple[float, float]]:
    """Luminance of the ground and of the ink, by class."""
    return {
        name: (
            luminance(int(red), int(green), int(blue)),
            luminance(*bytes.fromhex(ink)),
        )
        for name, red, green, blue, ink in SHADE.findall(sheet)
    }


LIGHT, DARK = style().split("@media screen and (prefers-color-scheme:dark)")


@pytest.mark.parametrize("sheet", [LIGHT, DARK])
def test_every_score_can_be_read_on_its_ground(sheet: str):
    found = shades(sheet)
    assert len(found) == 22
    for name, (ground, ink) in found.items():
        assert contrast(ground, ink) >= READABLE, name


@pytest.mark.parametrize("letter", ["h", "m"])
def test_on_paper_a_score_farther_from_0_is_darker(letter: str):
    grounds = [shades(LIGHT)[f"{letter}{k}"][0] for k in range(11)]
    assert grounds == sorted(grounds, reverse=True)
    assert len(set(grounds)) == len(grounds)
