"""Survival: which share of stretches without a contact goes on for longer than a given way."""

import math
from collections.abc import Sequence

from reflexarc_pictures.suite_page.markup import Markup, element, joined
from reflexarc_pictures.suite_page.page_content import Entry, PageContent
from reflexarc_pictures.suite_page.plot import (
    COLOURED,
    Plot,
    label,
    line_class,
    plot,
    shortened,
    spread_out,
)
from reflexarc_pictures.suite_page.tables import note, section
from reflexarc_pictures.suite_page.told import limits_of, survival
from reflexarc_sim_bridge.evaluation.metrics.track import Floats
from reflexarc_sim_bridge.evaluation.protocol.results import ResultRow

Curve = tuple[Floats, Floats]

_NAMES, _APART = 250.0, 15.0
_MOST = 30
"""Characters of a name beside its line."""


def survival_section(content: PageContent) -> Markup:
    """All families together, then each for itself."""
    title, anchor = "Survival", "survival"
    curves = _curves(content, None)
    if not curves:
        return section(title, anchor, note("These results hold no counts of lives."))
    longest = max(float(lengths[-1]) for _, (lengths, _) in curves)
    small = [
        element("div", element("h3", family), _panel(content, family, longest), class_="card panel")
        for family in content.families
        if _curves(content, family)
    ]
    return section(
        title,
        anchor,
        _all_families(content, curves, longest),
        note(
            "Share of stretches that go on without a contact for longer than a way, in mean free"
            " paths of an agent that never steers (Kaplan and Meier; what the end of a drive cuts"
            f" off is censored). At the {content.settings[0]}\u2019s rate and body. Dotted: that"
            " agent, as measured; where obstacles are independent it is e to the minus x. The"
            f" first {COLOURED} have colours, all others are grey.",
        ),
        element("div", small, class_="cards"),
    )


def _all_families(
    content: PageContent, curves: Sequence[tuple[Entry, Curve]], longest: float
) -> Markup:
    axes = plot(900.0, 380.0, (0.0, longest), (0.0, 1.0), (40.0, _NAMES, 44.0, 30.0))
    return axes.svg(
        "Survival over all families",
        axes.axes("way without a contact (mean free paths)", "share that goes on"),
        *_drawn(axes, content, curves, None),
        _names(axes, curves),
    )


def _panel(content: PageContent, family: str, longest: float) -> Markup:
    axes = plot(280.0, 190.0, (0.0, longest), (0.0, 1.0), (32.0, 10.0, 24.0, 10.0))
    curves = _curves(content, family)
    return axes.svg(
        f"Survival in {family}", axes.axes("", "", 4), *_drawn(axes, content, curves, family)
    )


def _drawn(
    axes: Plot, content: PageContent, curves: Sequence[tuple[Entry, Curve]], family: str | None
) -> list[Markup]:
    """Blind below, then the others, the best on top."""
    lines = []
    if curves and (blind := _blind(content, curves[0][0], family)):
        lines.append(axes.stairs(_points(blind), "blind"))
    for entry, curve in reversed(curves):
        lines.append(axes.stairs(_points(curve), line_class(entry.place)))
    return lines


def _curves(content: PageContent, family: str | None) -> list[tuple[Entry, Curve]]:
    found = []
    for entry in content.entries:
        curve = survival(_rows(content, entry, family))
        if curve is not None:
            found.append((entry, curve))
    return found


def _blind(content: PageContent, entry: Entry, family: str | None) -> Curve | None:
    rows = limits_of(content.results, _rows(content, entry, family), "blind")
    return survival(rows)


def _rows(content: PageContent, entry: Entry, family: str | None) -> list[ResultRow]:
    rows = content.rows(entry, content.settings[0])
    return [row for row in rows if family in (None, row.family)]


def _points(curve: Curve) -> list[tuple[float, float]]:
    return [(float(x), float(y)) for x, y in zip(*curve, strict=True) if math.isfinite(y)]


def _names(axes: Plot, curves: Sequence[tuple[Entry, Curve]]) -> Markup:
    """The names of the coloured lines, beside where these end."""
    named = [(entry, curve) for entry, curve in curves if entry.place <= COLOURED]
    ends = [(float(lengths[-1]), float(shares[-1])) for _, (lengths, shares) in named]
    wanted = [axes.up.at(share) for _, share in ends]
    places = spread_out(wanted, _APART, axes.up.end, axes.up.start)
    parts = []
    for (entry, _), (length, share), y in zip(named, ends, places, strict=True):
        x, own = axes.across.end + 26, line_class(entry.place)
        corners = f"{axes.across.at(length):.1f},{axes.up.at(share):.1f} {x - 8:.1f},{y:.1f}"
        parts.append(element("polyline", class_=f"leader {own}", points=corners))
        parts.append(label(x - 4, y + 4, f"{entry.place}  {shortened(entry.name, _MOST)}", own))
    return joined(parts)
