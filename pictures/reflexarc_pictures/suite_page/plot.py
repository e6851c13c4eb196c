"""A small figure as SVG: axes with a scale, and what is drawn in them.

Colours come from the page's style sheet, so that a figure follows its light or dark ground. Numbers
keep two decimals: the same figures give the same bytes.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from reflexarc_pictures.suite_page.markup import Markup, element, joined

COLOURED = 6
"""So many lines have a colour and a dash of their own; further ones are grey."""
_CHARACTER = 6.3
"""Width of one, about, in a figure's units."""


@dataclass(frozen=True)
class Scale:
    """From values to places along one side of a figure."""

    low: float
    high: float
    start: float
    end: float

    def at(self, value: float) -> float:
        """Where a value is; what is beyond an end is at it."""
        share = (value - self.low) / (self.high - self.low)
        return self.start + min(max(share, 0.0), 1.0) * (self.end - self.start)

    def ticks(self, most: int = 6) -> list[float]:
        """Round values on it."""
        step = round_step((self.high - self.low) / most)
        first = math.ceil(self.low / step - 1e-9)
        return [k * step for k in range(first, math.floor(self.high / step + 1e-9) + 1)]


@dataclass(frozen=True)
class Plot:
    """Axes: `across` from left to right, `up` from the bottom to the top."""

    width: float
    height: float
    across: Scale
    up: Scale

    def axes(self, across: str, up: str, ticks: int = 6) -> Markup:
        """Grid, ticks, and the names of both axes."""
        left, right, low, top = self.across.start, self.across.end, self.up.start, self.up.end
        parts = []
        for value in self.up.ticks(ticks):
            y = self.up.at(value)
            parts.append(element("line", class_="grid", x1=left, x2=right, y1=y, y2=y))
            parts.append(label(left - 6, y + 4, f"{value:g}", "tick end"))
        for value in self.across.ticks(ticks):
            x = self.across.at(value)
            parts.append(element("line", class_="grid", x1=x, x2=x, y1=low, y2=low + 4))
            parts.append(label(x, low + 17, f"{value:g}", "tick middle"))
        parts.append(element("line", class_="axis", x1=left, x2=right, y1=low, y2=low))
        if across:
            parts.append(label((left + right) / 2, low + 35, across, "name middle"))
        if up:
            parts.append(label(2, top - 10, up, "name"))
        return joined(parts)

    def line(self, points: Iterable[tuple[float, float]], class_: str) -> Markup:
        """A line through points."""
        places = [(self.across.at(x), self.up.at(y)) for x, y in points]
        return element("polyline", class_=f"line {class_}", points=_points(places))

    def stairs(self, points: Sequence[tuple[float, float]], class_: str) -> Markup:
        """A line that keeps its height until the next point."""
        corners = list(points[:1])
        for x, y in points[1:]:
            corners += [(x, corners[-1][1]), (x, y)]
        return self.line(corners, class_)

    def svg(self, title: str, *children: Markup) -> Markup:
        """The figure; the title is for whoever does not see it."""
        return svg(self.width, self.height, title, *children)


def svg(width: float, height: float, title: str, *children: Markup) -> Markup:
    """An SVG element of this size, as wide as its place allows."""
    return element(
        "svg",
        element("title", title),
        *children,
        viewBox=f"0 0 {width:g} {height:g}",
        role="img",
        style=f"max-width:{width:g}px",
    )


def plot(
    width: float,
    height: float,
    across: tuple[float, float],
    up: tuple[float, float],
    margins: tuple[float, float, float, float] = (40.0, 14.0, 44.0, 30.0),
) -> Plot:
    """Axes between values, with margins: left, right, below, above."""
    left, right, below, above = margins
    return Plot(
        width,
        height,
        Scale(*across, left, width - right),
        Scale(*up, height - below, above),
    )


def label(x: float, y: float, words: str, class_: str = "") -> Markup:
    """Text in a figure."""
    return element("text", words, x=x, y=y, class_=class_ or None)


def spread_out(wanted: Sequence[float], apart: float, low: float, high: float) -> list[float]:
    """Places near the wanted ones, in their order, apart from each other, between two ends.

    Args:
        wanted: places.
        apart: least distance; less where there is no room for it.
        low: no place is below it.
        high: no place is above it.
    """
    apart = min(apart, (high - low) / max(len(wanted) - 1, 1))
    order = sorted(range(len(wanted)), key=lambda k: (wanted[k], k))
    places = list(wanted)
    at = -math.inf
    for k in order:
        at = places[k] = max(places[k], at + apart, low)
    at = math.inf
    for k in reversed(order):
        at = places[k] = min(places[k], at - apart, high)
    return places


def shortened(words: str, most: int) -> str:
    """A name that fits: of a long one its end, which tells files apart."""
    return words if len(words) <= most else f"\u2026{words[1 - most :]}"


def line_class(place: int) -> str:
    """Colour and dash of an entry's line by its place."""
    return f"c{place}" if place <= COLOURED else "c0"


def round_step(least: float) -> float:
    """The least of 1, 2, 5 · 10ⁿ that is no less."""
    power = 10.0 ** math.floor(math.log10(least))
    return next(step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= least * 0.9999)


def text_width(words: str) -> float:
    """About how much room words take."""
    return _CHARACTER * len(words)


def _points(places: Iterable[tuple[float, float]]) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
