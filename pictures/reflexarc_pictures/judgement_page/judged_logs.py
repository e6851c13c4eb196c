"""The parts of the page that show one log each: its flips over time, its incidents, its flips."""

from collections.abc import Iterable, Sequence

from reflexarc_logs.judging.amounts import share
from reflexarc_logs.judging.judgement import IncidentAnswer, JudgedFlip, LogJudgement
from reflexarc_pictures.judgement_page.flip_card import flip_card
from reflexarc_pictures.judgement_page.flips_over_time import flips_over_time
from reflexarc_pictures.judgement_page.verdict_board import MOST_DRAWN, anchor
from reflexarc_pictures.suite_page.markup import Child, Markup, element, joined
from reflexarc_pictures.suite_page.tables import note, row, table

MOST_CARDS = 600
"""Flips that are drawn one by one on the whole page, each a KiB or two."""
LEAST_CARDS = 8
"""And of each log, however many there are."""
_OPEN = 6
"""So many flips of a log are in view at once, and incidents; the others are folded away."""
_APART_S = 0.5
_HEAD = "incident", "tick", "time", "what the log says", "recorded action", "the candidate's"


def judged_logs(logs: Sequence[LogJudgement]) -> Markup:
    """A part for each log, as far as there is room."""
    drawn = logs[:MOST_DRAWN]
    most = max(LEAST_CARDS, MOST_CARDS // max(len(drawn), 1))
    parts = [_part(place, one, most) for place, one in enumerate(drawn)]
    if len(logs) > len(drawn):
        left = len(logs) - len(drawn)
        parts.append(note(f"{left} more logs, the least bad, stand in the table alone."))
    return joined(parts)


def _part(place: int, one: LogJudgement, most: int) -> Markup:
    inside: Iterable[Markup] = [note(one.problem)] if one.problem else _judged(one, most)
    return element(
        "section",
        element("h2", one.log),
        element(
            "p",
            element("b", one.verdict, class_=f"verdict v{one.exit_status}"),
            "".join(f" {words}." for words in one.broken),
        ),
        inside,
        id=anchor(place),
    )


def _judged(one: LogJudgement, most: int) -> list[Markup]:
    parts = [note(_counted(one))]
    parts += [note(f"Note: {words}.") for words in one.notes]
    if one.shown_flips or one.incidents:
        parts.append(element("div", flips_over_time(one), class_="card timeline"))
    if one.incidents:
        parts.append(_incidents(one))
    if one.shown_flips:
        parts.append(_flips(one, most))
    return parts


def _counted(one: LogJudgement) -> str:
    """What was counted, and what was not."""
    said = [
        f"{one.flips:,} flips at {one.ticks:,} ticks ({share(one.flips, one.ticks)})",
        f"{one.reversals:,} reversals",
    ]
    left_out = {
        "below the least margin": one.below_margin,
        "within rounding": one.rounding,
        "ticks while its memory warmed up": one.warming_up,
        "ticks with Q-values that are not finite": one.faults,
    }
    said += [f"{count:,} {words}" for words, count in left_out.items() if count]
    return f"{', '.join(said)}. Recorded policy {one.recorded_policy[:12] or 'unnamed'}."


def _incidents(one: LogJudgement) -> Markup:
    """Those answered otherwise first in view, the others to be unfolded, both by time."""
    otherwise = sorted(one.incidents, key=lambda each: each.recorded == each.candidate)
    shown, folded = (_incident_table(one, part) for part in (otherwise[:_OPEN], otherwise[_OPEN:]))
    more = f" {one.more_incidents:,} more are not listed." if one.more_incidents else ""
    return joined(
        element("h3", "What it answers where something happened"),
        shown,
        element("details", element("summary", f"{len(otherwise) - _OPEN} more"), folded)
        if len(otherwise) > _OPEN
        else "",
        note(
            "Its answer to what was seen at the last tick up to then at which the policy was"
            f" asked; what it would have led to is not known.{more}"
        ),
    )


def _incident_table(one: LogJudgement, incidents: Iterable[IncidentAnswer]) -> Markup:
    rows = [_incident(one, each) for each in sorted(incidents, key=lambda each: each.time_s)]
    return table(_HEAD, rows, class_="plain")


def _incident(one: LogJudgement, each: IncidentAnswer) -> Markup:
    differs, theirs = each.recorded != each.candidate, one.action(each.candidate)
    answer: Child = f"the same: {theirs}"
    if each.asked_tick < 0:
        answer = "not asked before"
    elif differs:
        answer = element("td", element("b", theirs), class_="other")
    return row(
        each.kind,
        element("td", str(each.tick), class_="num"),
        element("td", f"{each.time_s:.2f} s", class_="num"),
        element("td", each.words, class_="words"),
        one.action(each.recorded),
        answer,
    )


def _flips(one: LogJudgement, most: int) -> Markup:
    """The cards of the largest margins: of several moments in view, the others to be unfolded."""
    by_margin = sorted(one.shown_flips, key=lambda flip: (-flip.margin, flip.time_s))[:most]
    shown = _moments(by_margin)
    folded = [flip for flip in by_margin if flip not in shown]
    parts = [element("h3", "The flips of the largest margins"), _cards(one, shown)]
    if folded:
        words = element("summary", f"{len(folded)} more, by tick")
        parts.append(element("details", words, _cards(one, folded)))
    if left := one.flips - len(by_margin):
        parts.append(note(f"{left:,} flips of smaller margins are counted and not drawn."))
    parts.append(
        note(
            "Above, what both were given: a row a frame, the newest below, the leftmost ray first."
            " Bars go from the least Q-value of a policy to its greatest."
        )
    )
    return joined(parts)


def _moments(by_margin: Sequence[JudgedFlip]) -> list[JudgedFlip]:
    """The first of them that are no flips of the same moment, as those of ticks in a row are."""
    found: list[JudgedFlip] = []
    for flip in by_margin:
        if all(abs(flip.time_s - other.time_s) >= _APART_S for other in found):
            found.append(flip)
        if len(found) == _OPEN:
            break
    return found


def _cards(one: LogJudgement, flips: Sequence[JudgedFlip]) -> Markup:
    return element("div", [flip_card(one, flip) for flip in _in_order(flips)], class_="flips")


def _in_order(flips: Iterable[JudgedFlip]) -> list[JudgedFlip]:
    return sorted(flips, key=lambda flip: (flip.time_s, flip.tick))
