"""Tables of a page, and the colours of scores in them."""

from collections.abc import Iterable, Sequence

from reflexarc_pictures.suite_page.markup import Child, Markup, element, joined
from reflexarc_pictures.suite_page.told import number
from reflexarc_sim_bridge.evaluation.scoring.cell_figures import Interval

SHADES = 10
"""Of scores above 0, and as many below."""


def table(head: Iterable[Child], rows: Iterable[Markup], **attributes: str | None) -> Markup:
    """A table, in a box that scrolls sideways where it is too wide."""
    titles = [
        cell if isinstance(cell, Markup) and cell.startswith("<th") else element("th", cell)
        for cell in head
    ]
    inside = element(
        "table",
        element("thead", element("tr", titles)),
        element("tbody", rows),
        **attributes,
    )
    return element("div", inside, class_="wide")


def row(*cells: Child) -> Markup:
    """A row; a cell that is no `<td>` or `<th>` becomes one."""
    return element("tr", *map(_cell, cells))


def score_cell(score: Interval | None, decimals: int = 2, note: str = "") -> Markup:
    """A score in its colour, its interval below."""
    if score is None or score.value != score.value:
        return element("td", number(None), class_="none")
    parts: list[Markup] = [element("b", number(score.value, decimals))]
    if score.low is not None and score.high is not None:
        parts.append(element("i", interval_words(score, decimals)))
    if note:
        parts.append(element("i", note))
    return element("td", parts, class_=f"heat {shade(score.value)}")


def interval_words(score: Interval, decimals: int = 2) -> str:
    """From low to high; empty without an interval."""
    if score.low is None or score.high is None:
        return ""
    return f"{number(score.low, decimals)} \u2026 {number(score.high, decimals)}"


def shade(score: float) -> str:
    """The class of a score's colour: blue above 0, orange below."""
    k = round(max(-1.0, min(1.0, score)) * SHADES)
    return f"h{k}" if k >= 0 else f"m{-k}"


def bullets(items: Sequence[Child]) -> Markup:
    """A list."""
    return element("ul", [element("li", item) for item in items])


def section(title: str, anchor: str, *children: Child) -> Markup:
    """A part of the page, with its heading."""
    return element("section", element("h2", title), *children, id=anchor)


def paragraph(*children: Child) -> Markup:
    """A paragraph."""
    return element("p", *children)


def note(*children: Child) -> Markup:
    """A paragraph that explains, smaller."""
    return element("p", *children, class_="note")


def _cell(cell: Child) -> Markup:
    is_cell = isinstance(cell, Markup) and cell.startswith(("<td", "<th"))
    return joined(cell) if is_cell else element("td", cell)
