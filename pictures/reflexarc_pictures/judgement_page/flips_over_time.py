"""Flips over the time of a log: how sure the record was, and where something happened.

A dot is a flip, a diamond a reversal; its height is its margin. Incidents are lines from top to
bottom, solid where the candidate answers otherwise.
"""

import math

from reflexarc_logs.judging.judgement import IncidentAnswer, JudgedFlip, LogJudgement
from reflexarc_pictures.judgement_page.flip_card import figure_words
from reflexarc_pictures.suite_page.markup import Markup, element, joined
from reflexarc_pictures.suite_page.plot import Plot, label, plot, text_width

_WIDTH, _HEIGHT = 900.0, 270.0
_MARGINS = (56.0, 16.0, 44.0, 58.0)
_ROOM = 1.08
_LEAST_S, _LEAST_MARGIN = 0.1, 1e-6
_DIAMOND = 6.0


def flips_over_time(one: LogJudgement) -> Markup:
    """The figure of a log, with what its signs mean."""
    axes = plot(_WIDTH, _HEIGHT, _times(one), (0.0, _highest(one)), _MARGINS)
    figure = axes.svg(
        f"Flips over time: {one.log}",
        axes.axes("time since the log\u2019s first tick, s", ""),
        label(2, 14, "margin of the recorded action", "name"),
        *_incident_lines(axes, one),
        *(_flip(axes, one, flip) for flip in one.shown_flips),
    )
    return joined(element("div", figure, class_="wide"), _legend(one))


def _times(one: LogJudgement) -> tuple[float, float]:
    known = [flip.time_s for flip in one.shown_flips] + [each.time_s for each in one.incidents]
    low, high = min(known), max(known)
    beside = max(0.02 * (high - low), _LEAST_S)
    return max(0.0, low - beside), high + beside


def _highest(one: LogJudgement) -> float:
    finite = [flip.margin for flip in one.shown_flips if math.isfinite(flip.margin)]
    return max(_LEAST_MARGIN, *finite) * _ROOM if finite else 1.0


def _flip(axes: Plot, one: LogJudgement, flip: JudgedFlip) -> Markup:
    margin = flip.margin if math.isfinite(flip.margin) else axes.up.high
    x, y = axes.across.at(flip.time_s), axes.up.at(margin)
    told = element("title", _told(one, flip))
    if flip.is_reversal:
        r = _DIAMOND
        corners = f"{x:.1f},{y - r:.1f} {x + r:.1f},{y:.1f} {x:.1f},{y + r:.1f} {x - r:.1f},{y:.1f}"
        sign = element("path", d=f"M{corners}Z", class_="dot c2")
    else:
        sign = element("circle", cx=x, cy=y, r=4, class_="dot c1")
    return element("g", told, sign)


def _told(one: LogJudgement, flip: JudgedFlip) -> str:
    was, now = one.action(flip.recorded), one.action(flip.candidate)
    margin = figure_words(flip.margin)
    return f"tick {flip.tick}, {flip.time_s:.2f} s: {was} \u2192 {now}, margin {margin}"


def _incident_lines(axes: Plot, one: LogJudgement) -> list[Markup]:
    """A line each; its kind above it, where that covers no other one."""
    parts, free_from = [], -math.inf
    for each in sorted(one.incidents, key=lambda each: each.time_s):
        x = axes.across.at(each.time_s)
        differs = each.recorded != each.candidate
        line = element(
            "line",
            class_=f"incident{'' if differs else ' same'}",
            x1=x,
            x2=x,
            y1=axes.up.start,
            y2=axes.up.end - 4,
        )
        parts.append(element("g", element("title", _happened(one, each)), line))
        width = text_width(each.kind)
        if x - width / 2 > free_from:
            parts.append(label(x, axes.up.end - 8, each.kind, "tick middle"))
            free_from = x + width / 2 + 4
    return parts


def _happened(one: LogJudgement, each: IncidentAnswer) -> str:
    was, now = one.action(each.recorded), one.action(each.candidate)
    return f"{each.kind} at tick {each.tick}, {each.time_s:.2f} s: {was} \u2192 {now}"


def _legend(one: LogJudgement) -> Markup:
    known = [
        ("\u25cf", "f1", "flip"),
        ("\u25c6", "f2", "reversal"),
        ("\u2502", "", "incident, answered otherwise"),
        ("\u2506", "", "incident, answered as recorded"),
    ]
    signs = [
        joined(element("span", element("b", sign, class_=colour or None), f" {words}"), " ")
        for sign, colour, words in known
    ]
    more = f"{one.more_flips:,} flips of smaller margins are not drawn." if one.more_flips else ""
    return element("p", signs, more, class_="legend note")
