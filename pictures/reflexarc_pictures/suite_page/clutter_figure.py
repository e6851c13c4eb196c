"""Clutter: contacts as a share of those of an agent that never steers, the denser the world.

Above is that agent, at 1; below is the oracle, which knows everything. In between is what a policy
makes of what can be done. Shaded: where the theory of Karaman and Frazzoli (arXiv 1202.0253) has
its critical clutter for w = v, 0.20 to 0.25; beyond it every way ends in a contact sooner or later.
"""

from collections.abc import Sequence

from reflexarc_pictures.suite_page.markup import Markup, element, joined
from reflexarc_pictures.suite_page.page_content import Entry, PageContent
from reflexarc_pictures.suite_page.plot import Plot, label, line_class, plot
from reflexarc_pictures.suite_page.tables import note, section
from reflexarc_pictures.suite_page.told import CONTACTS, limits_of
from reflexarc_sim_bridge.evaluation.protocol.results import CellFacts

CRITICAL = (0.20, 0.25)
_LEAST_AXIS = 0.32
_WORST = 1.25
"""Top of the axis, in contacts of an agent that never steers."""

Points = list[tuple[float, float]]


def clutter_section(content: PageContent) -> Markup:
    """A figure for each family with several degrees of clutter."""
    families = [
        family
        for family in content.families
        if len({cell.clutter for cell in _degrees(content, family)}) > 1
    ]
    shown = [
        element("div", element("h3", family), _figure(content, family), class_="card")
        for family in families
    ]
    title, anchor = "Clutter", "clutter"
    if not shown:
        return section(title, anchor, note("No family of these results has degrees of clutter."))
    return section(
        title,
        anchor,
        element("div", shown, class_="two"),
        _legend(content),
        note(
            "Contacts per metre, over those of an agent that never steers in the same worlds:"
            " 1 is that agent (dotted), the lowest line an oracle that knows everything, where one"
            " was found (dashed); what is above the axis stands at its upper end. Shaded: the"
            " critical clutter of the theory for v = w. At the"
            f" {content.settings[0]}\u2019s rate and body; bodies that turn are left out, as they"
            " have no way ahead."
        ),
    )


def _figure(content: PageContent, family: str) -> Markup:
    degrees = [cell.clutter or 0.0 for cell in _degrees(content, family)]
    axes = plot(520.0, 330.0, (0.0, max(_LEAST_AXIS, *degrees)), (0.0, _WORST))
    entries = [entry for entry in content.entries if not entry.turns]
    lines = [
        joined(
            axes.line(points, line_class(entry.place)),
            [_dot(axes, point, line_class(entry.place)) for point in points],
        )
        for entry in reversed(entries)
        if (points := _points(content, entry, family))
    ]
    oracles = _oracles(content, entries, family)
    return axes.svg(
        f"Contacts by clutter in {family}",
        _critical(axes),
        axes.axes("clutter \u03c1R\u00b2", "contacts / those of blind"),
        axes.line([(0.0, 1.0), (axes.across.high, 1.0)], "blind"),
        *(axes.line(points, "oracle") for points in oracles),
        *lines,
        *(
            label(axes.across.at(p[-1][0]) - 4, axes.up.at(p[-1][1]) - 6, "oracle", "tick end")
            for p in oracles[:1]
        ),
        label(axes.across.start + 6, axes.up.at(1.0) - 6, "never steers", "tick"),
    )


def _critical(axes: Plot) -> Markup:
    low, high = (axes.across.at(value) for value in CRITICAL)
    top = axes.up.end
    return element(
        "rect", class_="critical", x=low, y=top, width=high - low, height=axes.up.start - top
    )


def _degrees(content: PageContent, family: str) -> list[CellFacts]:
    cells = [c for c in content.results.cells if c.family == family and c.clutter is not None]
    return sorted(cells, key=lambda cell: cell.clutter or 0.0)


def _points(content: PageContent, entry: Entry, family: str, limit: str = "") -> Points:
    """By clutter: contacts of an entry, or of one of its limits, over those of its blind agent."""
    points = []
    for cell in _degrees(content, family):
        rows = [
            row
            for row in content.rows(entry, content.settings[0])
            if (row.family, row.tier) == (cell.family, cell.tier)
        ]
        own = CONTACTS.of(limits_of(content.results, rows, limit) if limit else rows)
        blind = CONTACTS.of(limits_of(content.results, rows, "blind"))
        if own is not None and blind:
            points.append((cell.clutter or 0.0, own / blind))
    return points


def _oracles(content: PageContent, entries: Sequence[Entry], family: str) -> list[Points]:
    """Those of all motions, each once."""
    found: list[Points] = []
    for entry in entries:
        points = _points(content, entry, family, "oracle")
        if points and points not in found:
            found.append(points)
    return found


def _dot(axes: Plot, point: tuple[float, float], class_: str) -> Markup:
    x, y = axes.across.at(point[0]), axes.up.at(point[1])
    return element("circle", class_=f"dot {class_}", cx=x, cy=y, r=3)


def _legend(content: PageContent) -> Markup:
    shown = [
        element(
            "span",
            element(
                "svg",
                element("line", class_=f"line {line_class(e.place)}", x1=0, x2=28, y1=6, y2=6),
                viewBox="0 0 28 12",
                width=28,
                height=12,
            ),
            f" {e.place} {e.name}",
        )
        for e in content.entries
        if not e.turns and line_class(e.place) != "c0"
    ]
    return element("p", shown, class_="legend")
