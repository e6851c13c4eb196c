"""Scores by family, by tier, and under perturbations: tables whose colours say the same as numbers.

Blue is better than never steering and orange worse, paler is nearer to 0: two hues that all kinds
of colour-blindness tell apart, and that differ in brightness on paper.
"""

from collections.abc import Sequence

import numpy as np

from reflexarc_pictures.suite_page.markup import Markup, element
from reflexarc_pictures.suite_page.page_content import Entry, PageContent
from reflexarc_pictures.suite_page.tables import note, row, score_cell, section, table
from reflexarc_pictures.suite_page.told import number
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.scoring.cell_figures import Interval
from reflexarc_sim_bridge.evaluation.scoring.robustness import FAMILY, NOMINAL
from reflexarc_sim_bridge.evaluation.scoring.scored_cells import CellScore


def families_section(content: PageContent) -> Markup:
    """Contender by family, a table for each setting."""
    tables = []
    for setting in content.settings:
        tables += [element("h3", f"At the {setting}\u2019s rate and body")]
        tables += [_families(content, setting)]
    return section("Score by family", "families", *tables, _key(), _questions(content))


def tiers_section(content: PageContent) -> Markup:
    """For each family its cells: score, and contacts or distance."""
    setting = content.settings[0]
    tables = [
        element("div", element("h3", family), _tiers(content, family, setting), class_="card")
        for family in content.families
        if family != FAMILY
    ]
    return section(
        "Score by tier",
        "tiers",
        note(
            f"At the {setting}\u2019s rate and body. Below each score: its 95 % interval, and"
            " contacts per 100 m or, of a body that turns, the greatest distance from its start"
            " before the first contact (m). A star marks cells that count for no score."
        ),
        element("div", tables, class_="cards"),
    )


def robustness_section(content: PageContent) -> Markup:
    """The world as it is beside the same made worse, degree by degree."""
    setting, title, anchor = content.settings[0], "Robustness", "robustness"
    tiers = [cell.tier for cell in content.results.cells if cell.family == FAMILY]
    if not tiers:
        return section(title, anchor, note("This suite has no grid of worlds made worse."))
    lines = [
        _robustness_line(entry, setting, tiers)
        for entry in content.entries
        if setting in entry.cards
    ]
    return section(
        title,
        anchor,
        table(["contender", "area", *tiers], lines, class_="heat-table"),
        note(
            f"At the {setting}\u2019s rate and body: one world as it is ({NOMINAL}), and made"
            " worse. Area: the mean score where it is made worse, over that where it is not; 1 is a"
            " contender that nothing disturbs."
        ),
    )


def _families(content: PageContent, setting: Setting) -> Markup:
    shown = [entry for entry in content.entries if setting in entry.cards]
    cards = [entry.cards[setting] for entry in shown]
    families = [f for f in content.families if any(f in card.families for card in cards)]
    lines = [
        row(_name(entry), *(score_cell(card.families.get(family)) for family in families))
        for entry, card in zip(shown, cards, strict=True)
    ]
    return table(["contender", *families], lines, class_="heat-table")


def _tiers(content: PageContent, family: str, setting: Setting) -> Markup:
    facts = [cell for cell in content.results.cells if cell.family == family]
    head = ["", *(cell.tier if cell.counts else f"{cell.tier} *" for cell in facts)]
    lines = []
    for entry in content.entries:
        if setting in entry.cards:
            scores = _cells(entry, setting)
            shown = [_tier_cell(scores.get((cell.family, cell.tier), [])) for cell in facts]
            lines.append(row(_name(entry), *shown))
    return table(head, lines, class_="heat-table small")


def _tier_cell(cells: Sequence[CellScore]) -> Markup:
    if len(cells) != 1:
        return score_cell(_mean(cells))
    cell = cells[0]
    if cell.farthest_m is not None:
        return score_cell(cell.score, note=f"{number(cell.farthest_m.value, 1)} m")
    contacts = None if cell.contacts_per_100m is None else cell.contacts_per_100m.value
    return score_cell(cell.score, note=f"{number(contacts, 1)} / 100 m")


def _robustness_line(entry: Entry, setting: Setting, tiers: Sequence[str]) -> Markup:
    cells = _cells(entry, setting)
    area = number(entry.cards[setting].robustness_area)
    shown = [score_cell(_mean(cells.get((FAMILY, tier), []))) for tier in tiers]
    return row(_name(entry), element("td", element("b", area)), *shown)


def _cells(entry: Entry, setting: Setting) -> dict[tuple[str, str], list[CellScore]]:
    """By family and tier: of each member of the entry one."""
    found: dict[tuple[str, str], list[CellScore]] = {}
    for cells in entry.cards[setting].cells.values():
        for cell in cells:
            found.setdefault((cell.family, cell.tier), []).append(cell)
    return found


def _mean(cells: Sequence[CellScore]) -> Interval | None:
    """Of one cell its score; of several seeds' the mean, without an interval."""
    if len(cells) == 1:
        return cells[0].score
    values = [cell.score.value for cell in cells if np.isfinite(cell.score.value)]
    return Interval(float(np.mean(values)), None, None) if values else None


def _name(entry: Entry) -> Markup:
    place = element("span", str(entry.place), class_="place")
    return element("th", place, f" {entry.name}", scope="row")


def _key() -> Markup:
    scores = [-1.0, -0.5, 0.0, 0.25, 0.5, 0.75, 1.0]
    shown = [score_cell(Interval(score, None, None)) for score in scores]
    caption = row(element("th", "worse than never steering"), *shown, element("th", "possible"))
    return element("table", element("tbody", caption), class_="heat-table key")


def _questions(content: PageContent) -> Markup:
    if content.suite is None:
        return element("span")
    known = {family.name: family for family in content.suite.families}
    asked = [
        row(
            element("th", name, scope="row"),
            known[name].question,
            "held out" if known[name].is_held_out else "learned in by presets",
        )
        for name in content.families
        if name in known
    ]
    return table(["family", "what it asks", "learning"], asked, class_="plain")
