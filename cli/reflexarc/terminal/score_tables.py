"""A suite's score cards as tables: family by contender, and a line for each contender."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

from rich.box import SIMPLE_HEAD
from rich.table import Table

from reflexarc.terminal.field_tables import interval_words
from reflexarc_runtime.words.shown import plain

if TYPE_CHECKING:
    from reflexarc_sim_bridge.evaluation.protocol.results import ResultRow, Results
    from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
    from reflexarc_sim_bridge.evaluation.scoring.score_card import ScoreCard

_SWITCHES = "switches"
"""Name of the sum, where it is measured."""


def score_tables(results: "Results", cards: "Sequence[ScoreCard]") -> list[Table]:
    """For each setting the families, then the headlines."""
    settings = list(dict.fromkeys(card.setting for card in cards))
    tables = []
    for setting in settings:
        chosen = [card for card in cards if card.setting == setting]
        tables += [_families(results, chosen, setting), _headlines(results, chosen, setting)]
    return tables


def _families(results: "Results", cards: "Sequence[ScoreCard]", setting: "Setting") -> Table:
    title = f"{results.suite}, {setting}: score by family (1 best, 0 blind)"
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    table.add_column("family", no_wrap=True)
    short = short_names([card.name for card in cards])
    for card in cards:
        table.add_column(plain(short[card.name]), justify="right", overflow="fold")
    for family in dict.fromkeys(name for card in cards for name in card.families):
        scores = [card.families.get(family) for card in cards]
        table.add_row(plain(family), *("–" if s is None else f"{s.value:.2f}" for s in scores))
    return table


def _headlines(results: "Results", cards: "Sequence[ScoreCard]", setting: "Setting") -> Table:
    table = Table(
        title=f"{results.suite}, {setting}: headline; contacts per 100 m, switches a second",
        title_justify="left",
        box=SIMPLE_HEAD,
        pad_edge=False,
        padding=(0, 1, 0, 0),
    )
    table.add_column("contender", overflow="fold")
    right = "score", "95 % interval", "gap", "robust", "per 100 m", "switches"
    for name in (*right[:2], "worst family", *right[2:]):
        table.add_column(name, justify="left" if name == "worst family" else "right")
    short = short_names([card.name for card in cards])
    for card in cards:
        table.add_row(plain(short[card.name]), *_headline(results, card))
    return table


def short_names(names: Sequence[str]) -> dict[str, str]:
    """Paths by as few of their last parts as tell them apart, other names as they are."""
    return {name: _short(name, names) for name in names}


def _short(name: str, names: Sequence[str]) -> str:
    parts = name.split("/")
    for count in range(1, len(parts)):
        tail = "/".join(parts[-count:])
        if sum(f"/{other}".endswith(f"/{tail}") for other in names) == 1:
            return tail
    return name


def _headline(results: "Results", card: "ScoreCard") -> tuple[str, ...]:
    rows = [r for r in results.rows if r.contender in card.members and r.setting == card.setting]
    worst = card.families[card.worst_family].value
    area = card.robustness_area
    interval = interval_words(card.headline, 3)
    return (
        f"{card.headline.value:.3f}",
        card.note if interval == "–" else interval,
        f"{plain(card.worst_family)} {worst:.2f}",
        f"{card.optimality_gap:.3f}",
        "–" if area is None else f"{area:.2f}",
        _contacts(card, rows),
        _switches(rows),
    )


def _contacts(card: "ScoreCard", rows: "Sequence[ResultRow]") -> str:
    """Over all cells together; none of a body that turns, which has no progress along x."""
    if any(cell.contacts_per_100m is None for cells in card.cells.values() for cell in cells):
        return "–"
    return f"{100.0 * _ratio(rows, 'contacts', 'progress_m'):.2f}"


def _switches(rows: "Sequence[ResultRow]") -> str:
    if not all(_SWITCHES in row.sums for row in rows):
        return "–"
    return f"{_ratio(rows, _SWITCHES, 'time_s'):.2f}"


def _ratio(rows: "Sequence[ResultRow]", above: str, below: str) -> float:
    total = sum(float(row.array(below).sum()) for row in rows)
    return sum(float(row.array(above).sum()) for row in rows) / max(total, 1e-9)
