"""The table of all judged logs, the worst first; a click on a heading sorts it otherwise."""

from collections.abc import Sequence

from reflexarc_logs.judging.amounts import share
from reflexarc_logs.judging.judgement import LogJudgement
from reflexarc_pictures.judgement_page.flip_card import figure_words
from reflexarc_pictures.suite_page.markup import Child, Markup, element, joined
from reflexarc_pictures.suite_page.tables import row, section, table

MOST_DRAWN = 60
"""Logs that have a part of their own on the page; the others have their row in the table."""
_HEAD = (
    "log",
    "verdict",
    "flips",
    "rate",
    "reversals",
    "ticks",
    "largest margin",
    "first flip",
    "incidents answered otherwise",
)


def verdict_board(logs: Sequence[LogJudgement]) -> Markup:
    """One row a log."""
    rows = [_row(k, one) for k, one in enumerate(logs)]
    return section("Logs", "logs", table(_HEAD, rows, id="board", class_="board"))


def anchor(place: int) -> str:
    """Where the part of a log is on the page."""
    return f"log-{place}"


def answered_otherwise(one: LogJudgement) -> int:
    """At how many incidents the candidate prefers another action."""
    return sum(each.recorded != each.candidate for each in one.incidents)


def _row(place: int, one: LogJudgement) -> Markup:
    name: Child = one.log
    if place < MOST_DRAWN:
        name = element("a", one.log, href=f"#{anchor(place)}")
    cells = [element("th", name), _verdict(one)]
    if one.problem:
        return row(*cells, *(_number("", None) for _ in _HEAD[2:]))
    first = f"tick {one.first_tick}, {one.first_s:.2f} s" if one.flips else ""
    return row(
        *cells,
        _number(f"{one.flips:,}", one.flips),
        _number(share(one.flips, one.ticks), one.rate),
        _number(f"{one.reversals:,}", one.reversals),
        _number(f"{one.ticks:,}", one.ticks),
        _number(figure_words(one.largest_margin) if one.flips else "", one.largest_margin),
        _number(first, one.first_s if one.flips else None),
        _number(_incidents(one), answered_otherwise(one)),
    )


def _verdict(one: LogJudgement) -> Markup:
    said = [one.problem] if one.problem else list(one.broken)
    return element(
        "td",
        element("b", one.verdict, class_=f"verdict v{one.exit_status}"),
        joined(element("span", words, class_="why") for words in said),
        data_v=str(-one.exit_status),
    )


def _incidents(one: LogJudgement) -> str:
    known = len(one.incidents)
    return f"{answered_otherwise(one)} of {known}" if known else ""


def _number(words: str, value: float | None) -> Markup:
    return element("td", words, class_="num", data_v="" if value is None else f"{value:.9g}")
