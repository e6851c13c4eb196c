"""Draws a course from above, with artists that are made once and moved from frame to frame."""

from collections.abc import Sequence

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection

from reflexarc_pictures.courses.course import Course, Snapshot
from reflexarc_pictures.log_pictures.decision_strips import INK
from reflexarc_pictures.log_pictures.drive import CONTACT_COLOUR
from reflexarc_pictures.log_pictures.logged_poses import Floats
from reflexarc_sim_bridge.worlds.silhouettes import Area, circle

GROUND_COLOUR = "#f5f3ee"
AGENT_COLOUR, BODY_COLOUR, RAY_COLOUR = "#c8402f", "#7a2318", "#c8402f"
SHOWN_CONTACT_S = 0.5
"""How long the agent changes its colour after a contact."""

_ARROW = np.array([(1.0, 0.0), (-0.55, 0.6), (-0.25, 0.0), (-0.55, -0.6)])
"""An arrow head that points ahead, for the agent's heading."""


class TopView:
    """Ground, obstacles, path, contacts, rays and the agent of one course.

    Args:
        axes: where to draw.
        course: what to draw.
        nose_m: half the length of the agent's arrow.
    """

    def __init__(self, axes: Axes, course: Course, nose_m: float) -> None:
        self._axes, self._course, self._nose_m = axes, course, nose_m
        axes.set_facecolor(GROUND_COLOUR)
        axes.set_aspect("equal")
        self._wakes = LineCollection([], linewidths=2.0, zorder=2, capstyle="round")
        self._obstacles = PolyCollection([], linewidths=0.7, zorder=3)
        self._far = LineCollection([], colors=RAY_COLOUR, linewidths=0.6, alpha=0.25, zorder=4)
        self._near = LineCollection([], colors=RAY_COLOUR, linewidths=0.9, alpha=0.75, zorder=4)
        self._agent = PolyCollection([], edgecolors="white", linewidths=0.8, zorder=7)
        for collection in (self._wakes, self._obstacles, self._far, self._near, self._agent):
            axes.add_collection(collection, autolim=False)
        (self._path,) = axes.plot([], [], color=INK, linewidth=1.5, zorder=5)
        (self._met,) = axes.plot([], [], "o", color=RAY_COLOUR, markersize=2.6, zorder=5)
        (self._contacts,) = axes.plot([], [], "X", color=CONTACT_COLOUR, markersize=7.5, zorder=6)
        self._contacts.set_markeredgecolor(INK)

    @property
    def artists(self) -> list[Artist]:
        """What changes from snapshot to snapshot, the lowest first."""
        above = [self._path, self._met, self._contacts, self._agent]
        return [self._wakes, self._obstacles, self._far, self._near, *above]

    def show(self, k: int, area: Area, y_shift_m: Floats | None = None) -> None:
        """Show an area at the time of a snapshot.

        Args:
            k: index of the snapshot.
            area: the part of the plane that the axes show.
            y_shift_m: added to every y of the path so far: (snapshots,).
        """
        course, snapshot = self._course, self._course.snapshots[k]
        shift_m = np.zeros(len(course.snapshots)) if y_shift_m is None else y_shift_m
        self._axes.set(xlim=area[:2], ylim=area[2:])
        self._show_obstacles(area, course.begins_s + k * course.period_s)
        x_m = np.array([snapshot.x_m for snapshot in course.snapshots[: k + 1]])
        y_m = np.array([snapshot.y_m for snapshot in course.snapshots[: k + 1]]) + shift_m[: k + 1]
        self._show_path(x_m, y_m, shift_m[: k + 1])
        self._show_rays(snapshot, float(shift_m[k]))
        self._show_agent(snapshot, float(shift_m[k]), self._has_just_met(k))

    def _show_obstacles(self, area: Area, time_s: float) -> None:
        shown = self._course.scenery.within(area, time_s)
        self._obstacles.set_verts([silhouette.corners_m for silhouette in shown])
        colours = np.array([silhouette.colour for silhouette in shown]).reshape(-1, 3)
        self._obstacles.set(facecolor=colours, edgecolor=0.82 * colours)
        moving = [silhouette for silhouette in shown if any(silhouette.wake_m)]
        middles = [silhouette.corners_m.mean(axis=0) for silhouette in moving]
        wakes = [(m - s.wake_m, m) for m, s in zip(middles, moving, strict=True)]
        self._wakes.set_segments(wakes)
        self._wakes.set_color([(*silhouette.colour, 0.6) for silhouette in moving])

    def _show_path(self, x_m: Floats, y_m: Floats, shift_m: Floats) -> None:
        snapshots = self._course.snapshots[: len(x_m)]
        put = np.array([snapshot.put for snapshot in snapshots])
        put[1:] |= np.diff(shift_m) != 0.0
        jumps = np.flatnonzero(put)
        self._path.set_data(np.insert(x_m, jumps, np.nan), np.insert(y_m, jumps, np.nan))
        # A contact is marked where the agent stood before it was placed elsewhere.
        met = [max(k - 1, 0) for k in self._course.contacts if k < len(x_m)]
        self._contacts.set_data(x_m[met], y_m[met])

    def _show_rays(self, snapshot: Snapshot, shift_m: float) -> None:
        eye = self._course.eye
        if snapshot.rays_m is None:
            return
        known = np.isfinite(snapshot.rays_m)
        rays_m, angles = snapshot.rays_m[known], snapshot.heading_rad + eye.bearings_rad[known]
        sin, cos = np.sin(snapshot.heading_rad), np.cos(snapshot.heading_rad)
        from_m = [snapshot.x_m - eye.left_m * sin, snapshot.y_m + shift_m + eye.left_m * cos]
        to_m = from_m + rays_m[:, np.newaxis] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        meets = rays_m < eye.range_m
        lines = np.stack([np.broadcast_to(from_m, to_m.shape), to_m], axis=1)
        self._near.set_segments(list(lines[meets]))
        self._far.set_segments(list(lines[~meets]))
        self._met.set_data(*to_m[meets].T)

    def _show_agent(self, snapshot: Snapshot, shift_m: float, has_met: bool) -> None:
        x_m, y_m = snapshot.x_m, snapshot.y_m + shift_m
        body = circle(x_m, y_m, self._course.radius_m)
        sin, cos = np.sin(snapshot.heading_rad), np.cos(snapshot.heading_rad)
        arrow = np.array([x_m, y_m]) + self._nose_m * _ARROW @ np.array([[cos, sin], [-sin, cos]])
        self._agent.set_verts([body, arrow])
        self._agent.set_facecolor([BODY_COLOUR, CONTACT_COLOUR if has_met else AGENT_COLOUR])

    def _has_just_met(self, k: int) -> bool:
        latest: Sequence[int] = [c for c in self._course.contacts if c <= k]
        return bool(latest) and (k - latest[-1]) * self._course.period_s < SHOWN_CONTACT_S
