"""The page: its parts one below the other, in one file.

Nothing in it is loaded from elsewhere, which a rule in its head holds the browser to. The same
content gives the same bytes.
"""

from pathlib import Path

from reflexarc_pictures.suite_page.clutter_figure import clutter_section
from reflexarc_pictures.suite_page.dot_figures import chatter_section, edges_section
from reflexarc_pictures.suite_page.heat_tables import (
    families_section,
    robustness_section,
    tiers_section,
)
from reflexarc_pictures.suite_page.leaderboard import leaderboard
from reflexarc_pictures.suite_page.markup import Markup, element, joined
from reflexarc_pictures.suite_page.moment_picture import moments_section
from reflexarc_pictures.suite_page.page_content import PageContent
from reflexarc_pictures.suite_page.specification import (
    agents_section,
    protocol_section,
    reproduction_section,
)
from reflexarc_pictures.suite_page.style import SORTING, style
from reflexarc_pictures.suite_page.survival_figure import survival_section
from reflexarc_pictures.suite_page.tables import interval_words
from reflexarc_pictures.suite_page.told import number
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.files import write_atomically

_SECTIONS = (
    leaderboard,
    families_section,
    tiers_section,
    robustness_section,
    survival_section,
    clutter_section,
    chatter_section,
    edges_section,
    moments_section,
    agents_section,
    protocol_section,
    reproduction_section,
)
_NOTHING_ELSE = (
    "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'"
)
_ANCHORS = {
    "leaderboard": "Leaderboard",
    "families": "Families",
    "tiers": "Tiers",
    "robustness": "Robustness",
    "survival": "Survival",
    "clutter": "Clutter",
    "chatter": "Chatter",
    "edges": "Edges",
    "moments": "Moments",
    "contenders": "Contenders",
    "protocol": "Protocol",
    "again": "Measure it again",
}


def write_page(content: PageContent, path: Path) -> int:
    """Write the page; an older file is replaced.

    Returns:
        Its size in bytes.

    Raises:
        UsageError: nobody was measured.
        OSError: the file cannot be written.
    """
    data = page_text(content).encode()
    write_atomically(path, data)
    return len(data)


def page_text(content: PageContent) -> str:
    """The page as text.

    Raises:
        UsageError: nobody was measured.
    """
    if not content.entries:
        raise UsageError("page: expected results of one contender or more, got none")
    title = f"reflexarc {content.results.suite}"
    head = element(
        "head",
        element("meta", charset="utf-8"),
        element("meta", http_equiv="Content-Security-Policy", content=_NOTHING_ELSE),
        element("meta", name="viewport", content="width=device-width, initial-scale=1"),
        element("title", title),
        element("style", Markup(style())),
    )
    body = element(
        "body",
        _opening(content),
        joined(section(content) for section in _SECTIONS),
        element("script", Markup(SORTING)),
    )
    return f"<!doctype html>\n{element('html', head, body, lang='en')}\n"


def _opening(content: PageContent) -> Markup:
    results, count = content.results, len(content.results.agents)
    who = f"{count} contender{'' if count == 1 else 's'}"
    links = [element("a", words, href=f"#{anchor}") for anchor, words in _ANCHORS.items()]
    return element(
        "header",
        element("h1", f"Obstacle avoidance: suite {results.suite}"),
        element("p", f"{who}, measured by reflexarc {results.version}", class_="note"),
        element("p", *_summary(content), class_="lead"),
        element("nav", links),
    )


def _summary(content: PageContent) -> list[Markup | str]:
    """The first of the board in words, and who cannot be told from it."""
    first = content.entries[0]
    card = first.cards[content.settings[0]]
    score, worst = card.headline, card.worst_family
    interval = interval_words(score)
    words: list[Markup | str] = [
        element("b", first.name),
        f" scores {number(score.value)}" + (f" ({interval})" if interval else ""),
        f" at the {content.settings[0]}\u2019s rate and body; its worst family is {worst},"
        f" {number(card.families[worst].value)}.",
    ]
    if len(content.entries) > 1 and score.low is not None:
        near = [
            entry.name
            for entry in content.entries[1:]
            if (other := entry.cards[content.settings[0]].headline).high is not None
            and other.high > score.low
        ]
        if near:
            words.append(f" The intervals of {_listed(near)} overlap with it.")
    return words


def _listed(names: list[str]) -> str:
    most = 4
    shown = names[:most] + ([f"{len(names) - most} more"] if len(names) > most else [])
    return shown[0] if len(shown) == 1 else f"{', '.join(shown[:-1])} and {shown[-1]}"
