"""Two figures with a dot for each contender: contacts against switches, and edge indices."""

from reflexarc_pictures.suite_page.markup import Markup, element, joined
from reflexarc_pictures.suite_page.page_content import Entry, PageContent
from reflexarc_pictures.suite_page.plot import (
    Plot,
    label,
    line_class,
    plot,
    shortened,
    text_width,
)
from reflexarc_pictures.suite_page.tables import note, section
from reflexarc_pictures.suite_page.told import CONTACTS, EDGES, SWITCHES, number

_MOST = 34
_ROOM = 1.08
_ROW = 22.0
_MOST_NAMED = 12
"""More dots have their places beside them, not their names."""


def chatter_section(content: PageContent) -> Markup:
    """Contacts against switches: to the lower left is better."""
    setting, title = content.settings[0], "Chatter"
    found = [
        (entry, switches, contacts)
        for entry in content.entries
        if not entry.turns
        and (switches := SWITCHES.of(content.rows(entry, setting))) is not None
        and (contacts := CONTACTS.of(content.rows(entry, setting))) is not None
    ]
    if not found:
        return section(title, "chatter", note("These results hold no switches."))
    most = max(switches for _, switches, _ in found), max(contacts for _, _, contacts in found)
    axes = plot(
        900.0,
        420.0,
        (0.0, max(most[0], 0.1) * _ROOM),
        (0.0, max(most[1], 0.1) * _ROOM),
        (46.0, 240.0, 44.0, 30.0),
    )
    return section(
        title,
        "chatter",
        axes.svg(
            "Contacts against switches",
            axes.axes("changes of action a second", "contacts / 100 m, all cells"),
            *_dots(axes, found),
        ),
        note(
            "How often an action changes, against how often something is touched: to the lower left"
            f" is better. At the {setting}\u2019s rate and body."
        ),
    )


def edges_section(content: PageContent) -> Markup:
    """The edge index of each contender, on one axis."""
    setting, title = content.settings[0], "Edges"
    found = [
        (entry, index)
        for entry in content.entries
        if (index := EDGES.of(content.rows(entry, setting))) is not None
    ]
    if not found:
        return section(title, "edges", note("These results hold no time at the sides."))
    height = _ROW * len(found) + 60.0
    highest = max(2.0, *(index for _, index in found)) * _ROOM
    axes = plot(900.0, height, (0.0, highest), (0.0, 1.0), (270.0, 60.0, 44.0, 8.0))
    return section(
        title,
        "edges",
        axes.svg(
            "Edge index",
            _edge_axis(axes),
            *(_edge_row(axes, k, *each) for k, each in enumerate(found)),
        ),
        note(
            "Share of the time within 2R of a side, over what is expected of a place drawn evenly:"
            " 1 has no preference, more keeps to the sides, less avoids them. In a periodic world"
            f" its seam counts as a side. At the {setting}\u2019s rate and body."
        ),
    )


def _edge_axis(axes: Plot) -> Markup:
    low, top, one = axes.up.start, axes.up.end, axes.across.at(1.0)
    even = element("line", class_="line blind", x1=one, x2=one, y1=low, y2=top)
    ticks = [
        label(axes.across.at(value), low + 17, f"{value:g}", "tick middle")
        for value in axes.across.ticks()
    ]
    middle = (axes.across.start + axes.across.end) / 2
    return joined(even, ticks, label(middle, low + 35, "edge index", "name middle"))


def _edge_row(axes: Plot, k: int, entry: Entry, index: float) -> Markup:
    y, x = axes.up.end + _ROW * (k + 0.5), axes.across.at(index)
    one, own = axes.across.at(1.0), line_class(entry.place)
    name = f"{shortened(entry.name, _MOST)}  {entry.place}"
    return joined(
        label(axes.across.start - 10, y + 4, name, "end"),
        element("line", class_="stem", x1=min(one, x), x2=max(one, x), y1=y, y2=y),
        element("circle", class_=f"dot {own}", cx=x, cy=y, r=5),
        label(
            x + (9 if index >= 1.0 else -9),
            y + 4,
            number(index),
            "tick" if index >= 1.0 else "tick end",
        ),
    )


def _dots(axes: Plot, found: list[tuple[Entry, float, float]]) -> list[Markup]:
    """Dots with names, each name where it covers no other."""
    taken: list[tuple[float, float, float]] = []
    parts = []
    for entry, switches, contacts in found:
        x, y, own = axes.across.at(switches), axes.up.at(contacts), line_class(entry.place)
        is_named = len(found) <= _MOST_NAMED
        words = f"{entry.place}  {shortened(entry.name, _MOST)}" if is_named else str(entry.place)
        at_y = _free_place(taken, x, y, text_width(words))
        taken.append((x, at_y, text_width(words)))
        parts.append(element("circle", class_=f"dot {own}", cx=x, cy=y, r=6))
        parts.append(label(x + 11, at_y + 4, words))
    return parts


def _free_place(taken: list[tuple[float, float, float]], x: float, y: float, width: float) -> float:
    """The height nearest to y at which words of this width cover no others."""
    for step in range(40):
        for side in (1.0, -1.0):
            at = y + side * 7.0 * step
            if not any(
                abs(at - other_y) < 14.0 and x < other_x + other and other_x < x + width
                for other_x, other_y, other in taken
            ):
                return at
    return y
