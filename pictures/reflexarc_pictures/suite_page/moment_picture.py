"""The worst moments as pictures: from above, up to the contact, and what the eye saw meanwhile.

Frame: x ahead to the right, y to the left upwards, metres, as in `courses/top_view.py`.
"""

import math
from collections.abc import Sequence

import numpy as np

from reflexarc_pictures.courses.course import Course, Snapshot
from reflexarc_pictures.suite_page.markup import Markup, element, joined
from reflexarc_pictures.suite_page.moment import Moment
from reflexarc_pictures.suite_page.page_content import PageContent
from reflexarc_pictures.suite_page.pixels import png_address
from reflexarc_pictures.suite_page.plot import label, svg
from reflexarc_pictures.suite_page.tables import note, section
from reflexarc_pictures.suite_page.told import MINUS, number
from reflexarc_sim_bridge.worlds.silhouettes import Area, Silhouette

_WIDTH, _STRIP_HEIGHT, _STRIP_GAP = 560.0, 84.0, 30.0
_HALF_M = 4.0
"""How far the picture reaches to each side of the contact."""
_BEHIND_M, _AHEAD_M = 5.0, 5.0
_NOSE_M = 0.28
_ARROW = ((1.0, 0.0), (-0.55, 0.6), (-0.25, 0.0), (-0.55, -0.6))
_LEAST_POINT = 3.0
_GROUND, _PATH, _RAY, _MET = "#f5f3ee", "#22313f", "#c8402f", "#f2b134"


def moments_section(content: PageContent) -> Markup:
    """A picture for each moment."""
    title, anchor = "Worst moments", "moments"
    if not content.moments:
        return section(title, anchor, note("No moment was driven again for this page."))
    who = content.moments[0].contender
    shown = [element("div", _card(moment), class_="card") for moment in content.moments]
    return section(
        title,
        anchor,
        note(
            f"Of {who}, in the cells that count where it scores least, and in the first of their"
            " worlds: in each the contact with something that had been straight ahead for longest."
            " From above, the seconds before; the cross is the contact, lines are the rays of the"
            " last look. Below: what the eye saw, its leftmost ray on top. The command draws the"
            " same drive again; with -o moment.gif as a film."
        ),
        element("div", shown, class_="two"),
    )


def _card(moment: Moment) -> Markup:
    warned = ""
    if moment.warning_s is not None:
        warned = f", straight ahead for {number(moment.warning_s, 1)} s before"
    return joined(
        element("h3", f"{moment.family}/{moment.tier}, world {moment.world}"),
        _picture(moment.course),
        element(
            "p",
            f"Seed {moment.seed}, lane {moment.lane}, step {moment.step},"
            f" {number(moment.at_s, 2)} s{warned}.",
            class_="note",
        ),
        element("pre", moment.command),
    )


def _picture(course: Course) -> Markup:
    """The snapshot before the contact is the last look; the one after it may be elsewhere."""
    snapshots = course.snapshots[:-1]
    area, scale = _area(snapshots[-1]), _WIDTH / (_BEHIND_M + _AHEAD_M)
    height = scale * (area.high_y_m - area.low_y_m)
    above = _Above(area, scale)
    inside = joined(
        element("rect", x=0, y=0, width=_WIDTH, height=height, fill=_GROUND),
        [above.obstacle(each) for each in _obstacles(course, area)],
        above.rays(course),
        above.path(snapshots),
        above.agent(course),
        _scale_bar(scale, height),
    )
    framed = element("svg", inside, x=0, y=0, width=_WIDTH, height=height, style="overflow:hidden")
    strip = _strip(course, height + _STRIP_GAP)
    total = height + _STRIP_GAP + _STRIP_HEIGHT + 20.0
    return svg(_WIDTH, total, "A contact from above, and what was seen", framed, strip)


class _Above:
    """From metres to places in the picture."""

    def __init__(self, area: Area, scale: float) -> None:
        self._area, self._scale = area, scale

    def at(self, x_m: float, y_m: float) -> tuple[float, float]:
        area, scale = self._area, self._scale
        return (x_m - area.low_x_m) * scale, (area.high_y_m - y_m) * scale

    def obstacle(self, silhouette: Silhouette) -> Markup:
        red, green, blue = (round(255 * part) for part in silhouette.colour)
        edge = f"rgb({red * 4 // 5},{green * 4 // 5},{blue * 4 // 5})"
        outline = element(
            "polygon",
            points=self._points(silhouette.corners_m.tolist()),
            fill=f"rgb({red},{green},{blue})",
            stroke=edge,
        )
        return joined(self._wake(silhouette, edge), outline)

    def rays(self, course: Course) -> Markup:
        snapshot, eye = course.snapshots[-2], course.eye
        if snapshot.rays_m is None:
            return Markup("")
        sin, cos = math.sin(snapshot.heading_rad), math.cos(snapshot.heading_rad)
        x_m, y_m = snapshot.x_m - eye.left_m * sin, snapshot.y_m + eye.left_m * cos
        lines = []
        for bearing, ray_m in zip(eye.bearings_rad.tolist(), snapshot.rays_m.tolist(), strict=True):
            if math.isfinite(ray_m):
                angle = snapshot.heading_rad + bearing
                end = self.at(x_m + ray_m * math.cos(angle), y_m + ray_m * math.sin(angle))
                faint = 0.25 if ray_m >= eye.range_m else 0.7
                lines.append(self._line(self.at(x_m, y_m), end, faint))
        return joined(lines)

    def path(self, snapshots: Sequence[Snapshot]) -> Markup:
        """Broken where the agent was put elsewhere."""
        pieces: list[list[tuple[float, float]]] = [[]]
        crosses = []
        for k, snapshot in enumerate(snapshots):
            if snapshot.put:
                pieces.append([])
            if snapshot.contact and k:
                crosses.append(self._cross(snapshots[k - 1], 5.0))
            pieces[-1].append((snapshot.x_m, snapshot.y_m))
        lines = [
            element(
                "polyline",
                points=self._points(piece),
                fill="none",
                stroke=_PATH,
                stroke_width=2.2,
                stroke_linejoin="round",
            )
            for piece in pieces
            if len(piece) > 1
        ]
        return joined(lines, crosses)

    def agent(self, course: Course) -> Markup:
        """Its body and heading at the last look, and the contact."""
        snapshot = course.snapshots[-2]
        x, y = self.at(snapshot.x_m, snapshot.y_m)
        sin, cos = math.sin(snapshot.heading_rad), math.cos(snapshot.heading_rad)
        corners = [
            (
                snapshot.x_m + _NOSE_M * (ahead * cos - left * sin),
                snapshot.y_m + _NOSE_M * (ahead * sin + left * cos),
            )
            for ahead, left in _ARROW
        ]
        body = element(
            "circle",
            cx=x,
            cy=y,
            r=max(course.radius_m * self._scale, _LEAST_POINT),
            fill="#7a2318",
            fill_opacity=0.75,
        )
        arrow = element(
            "polygon", points=self._points(corners), fill=_RAY, stroke="white", stroke_width=0.8
        )
        return joined(body, arrow, self._cross(snapshot, 9.0))

    def _cross(self, snapshot: Snapshot, arm: float) -> Markup:
        x, y = self.at(snapshot.x_m, snapshot.y_m)
        strokes = [
            element(
                "line",
                x1=x - arm,
                y1=y - k * arm,
                x2=x + arm,
                y2=y + k * arm,
                stroke=colour,
                stroke_width=width,
                stroke_linecap="round",
            )
            for colour, width in ((_PATH, 5.0), (_MET, 2.6))
            for k in (1.0, -1.0)
        ]
        return joined(strokes)

    def _wake(self, silhouette: Silhouette, colour: str) -> Markup:
        if not any(silhouette.wake_m):
            return Markup("")
        x_m, y_m = silhouette.corners_m.mean(axis=0).tolist()
        start = self.at(x_m - silhouette.wake_m[0], y_m - silhouette.wake_m[1])
        return self._line(start, self.at(x_m, y_m), 0.6, colour, 2.0)

    def _line(
        self,
        start: tuple[float, float],
        end: tuple[float, float],
        opacity: float,
        colour: str = _RAY,
        width: float = 0.9,
    ) -> Markup:
        (x1, y1), (x2, y2) = start, end
        return element(
            "line",
            x1=x1,
            y1=y1,
            x2=x2,
            y2=y2,
            stroke=colour,
            stroke_width=width,
            stroke_opacity=opacity,
        )

    def _points(self, places_m: Sequence[Sequence[float]]) -> str:
        return " ".join(f"{x:.1f},{y:.1f}" for x, y in (self.at(p[0], p[1]) for p in places_m))


def _area(snapshot: Snapshot) -> Area:
    x_m, y_m = snapshot.x_m, snapshot.y_m
    return Area(x_m - _BEHIND_M, x_m + _AHEAD_M, y_m - _HALF_M * 0.7, y_m + _HALF_M * 0.7)


def _obstacles(course: Course, area: Area) -> Sequence[Silhouette]:
    """As they were at the last look; where the world repeats, the snapshots may be beyond it."""
    at_s = course.begins_s + (len(course.snapshots) - 2) * course.period_s
    return course.scenery.within(area, at_s)


def _scale_bar(scale: float, height: float) -> Markup:
    y = height - 12.0
    halo = f"fill:{_PATH};font-size:11px;paint-order:stroke;stroke:{_GROUND};stroke-width:3px"
    return joined(
        element("line", x1=12, x2=12 + scale, y1=y, y2=y, stroke=_GROUND, stroke_width=5),
        element("line", x1=12, x2=12 + scale, y1=y, y2=y, stroke=_PATH, stroke_width=2),
        element("text", "1 m", x=14, y=y - 5, style=halo),
    )


def _strip(course: Course, top: float) -> Markup:
    """One column for each look, the newest at the right."""
    seen = [snapshot.retina for snapshot in course.snapshots[:-1] if snapshot.retina is not None]
    if not seen:
        return Markup("")
    pixels = np.stack([retina.reshape(-1, retina.shape[-1]) for retina in seen], axis=1)
    lead_s = len(seen) * course.period_s
    return joined(
        element(
            "image",
            href=png_address(pixels),
            x=0,
            y=top,
            width=_WIDTH,
            height=_STRIP_HEIGHT,
            preserveAspectRatio="none",
            style="image-rendering:pixelated",
        ),
        label(0, top - 8, f"what it saw (bright: {course.bright})", "tick"),
        label(0, top + _STRIP_HEIGHT + 15, f"{MINUS}{lead_s:.1f} s", "tick"),
        label(_WIDTH, top + _STRIP_HEIGHT + 15, "the last look", "tick end"),
    )
