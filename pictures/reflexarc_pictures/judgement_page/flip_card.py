"""One flip: what both policies were given, and the Q-values of both as bars.

The retina's rows are frames, the newest at the bottom, and eyes within a frame, the left one first;
its columns are rays, the leftmost first. The bars of a policy go from its least Q-value to its
greatest: Q-values of two policies need not have one unit, so each has a scale of its own.
"""

import math
from collections.abc import Sequence

import numpy as np

from reflexarc_logs.judging.judgement import JudgedFlip, LogJudgement
from reflexarc_pictures.suite_page.markup import Markup, element, joined
from reflexarc_pictures.suite_page.pixels import png_address
from reflexarc_pictures.suite_page.plot import label, shortened, svg

_WIDTH, _CELL, _MOST_HIGH = 320.0, 22.0, 110.0
_NAME, _BAR, _ROW, _BETWEEN = 74.0, 72.0, 22.0, 44.0
_LONGEST_NAME = 11
_MOST_ACTIONS = 24


def flip_card(one: LogJudgement, flip: JudgedFlip) -> Markup:
    """The card of a flip."""
    was, now = one.action(flip.recorded), one.action(flip.candidate)
    margins = figure_words(flip.margin), figure_words(flip.candidate_margin)
    kind = element("b", " reversal", class_="f2") if flip.is_reversal else Markup("")
    return element(
        "div",
        element("h4", f"tick {flip.tick}, {flip.time_s:.2f} s", kind),
        element("p", f"{was} \u2192 {now}", class_="turned"),
        _retina(flip.retina, one.retina_shape),
        _bars(one, flip),
        element(
            "p",
            f"margin {margins[0]} recorded, {margins[1]} the candidate\u2019s",
            class_="fine",
        ),
        class_="card flip",
    )


def figure_words(value: float) -> str:
    """A Q-value or a margin."""
    if not math.isfinite(value):
        return "not finite"
    return f"{value:.3g}".replace("-", "\u2212")


def _retina(data: bytes, shape: Sequence[int]) -> Markup:
    """Nothing where the bytes are of another shape."""
    if len(shape) != 4 or math.prod(shape) != len(data) or not data:
        return element("p", "no retina of this shape was kept", class_="fine")
    frames, eyes, rays, channels = shape
    pixels = np.frombuffer(data, np.uint8).reshape(frames * eyes, rays, channels)
    if channels not in (1, 3):
        pixels = pixels[:, :, :1]
    height = min(_CELL * frames * eyes, _MOST_HIGH)
    picture = element(
        "image",
        href=png_address(pixels),
        x=0,
        y=0,
        width=_WIDTH,
        height=height,
        preserveAspectRatio="none",
        style="image-rendering:pixelated",
    )
    frame = element("rect", class_="frame", x=0, y=0, width=_WIDTH, height=height)
    return svg(_WIDTH, height, "What both were given", picture, frame)


def _bars(one: LogJudgement, flip: JudgedFlip) -> Markup:
    """Both sets of Q-values, an action a row; of very many actions the first and the two chosen."""
    known = min(len(flip.recorded_q_values), len(flip.candidate_q_values))
    rows = list(range(min(known, _MOST_ACTIONS)))
    rows += [k for k in (flip.recorded, flip.candidate) if k not in rows and 0 <= k < known]
    right = _NAME + _BAR + _BETWEEN + 8.0
    parts = [
        label(_NAME, 12, "recorded", "tick"),
        label(right, 12, "candidate", "tick"),
        *(
            label(0, 20 + _ROW * (n + 0.65), shortened(one.action(k), _LONGEST_NAME), "tick")
            for n, k in enumerate(rows)
        ),
        _set(flip.recorded_q_values, flip.recorded, rows, _NAME),
        _set(flip.candidate_q_values, flip.candidate, rows, right),
    ]
    return svg(_WIDTH, 20.0 + _ROW * len(rows) + 4.0, "Q-values", *parts)


def _set(values: Sequence[float], chosen: int, rows: Sequence[int], left: float) -> Markup:
    """The bars of one policy."""
    finite = [value for value in values if math.isfinite(value)] or [0.0]
    lowest, span = min(finite), max(finite) - min(finite)
    parts = []
    for n, k in enumerate(rows):
        y, is_known = 20.0 + _ROW * n, math.isfinite(values[k])
        share = (values[k] - lowest) / span if is_known and span > 0.0 else 0.0
        width = max(_BAR * share, 1.0)
        own = "bar" if k == chosen else "bar pale"
        parts.append(
            element("rect", class_=own, x=left, y=y + 4, width=width, height=_ROW - 8, rx=2)
        )
        name = "told" if k == chosen else "tick"
        parts.append(label(left + width + 4, y + _ROW * 0.68, figure_words(values[k]), name))
    return joined(parts)
