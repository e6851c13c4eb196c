"""Draws with Rerun, in the extra `view`: in a viewer that is open, or into a file.

Rerun shows of a log by itself only what it knows, the retina's strip and poses; so everything is
sent as what it can draw. All of it is on one time line, `message_log_time`, which is the wall clock
and has the name that Rerun gives it when it opens a log by itself; ticks are also on `tick`.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from reflexarc_logs.viewing import drawings as draw
from reflexarc_logs.viewing.drawings import Drawing

APPLICATION = "reflexarc"
TIME = "message_log_time"
TICK = "tick"
_ROBOT_COLOUR = (213, 94, 0)
_PATH_COLOUR = (0, 114, 178)
_WAY_COLOUR = (140, 150, 160)
_SCAN_COLOUR = (0, 158, 115)
_ACTION_COLOURS = (
    *((0, 158, 115), (0, 114, 178), (213, 94, 0)),  # the paper's three: stay, left, right
    *((204, 121, 167), (230, 159, 0), (86, 180, 233), (240, 228, 66)),
)
"""As in our own pictures: Okabe and Ito, "Color Universal Design" (2008)."""
_SPEEDS = ("ahead, m/s", "to the left, m/s", "turning, rad/s")


class RerunCanvas:
    """One recording of Rerun.

    Args:
        name: of the recording: a log's, a robot's.
        identity: tells it from others of that name.
        actions: the names of the policy's actions; empty where they are not known.
    """

    def __init__(self, name: str, identity: str, actions: Sequence[str] = ()) -> None:
        self._stream = rr.RecordingStream(APPLICATION, recording_id=f"{identity} {name}")
        self._stream.set_log_time_enabled(False)  # when it was sent here is nobody's business
        self._stream.set_log_tick_enabled(False)
        self._name = name
        self._blueprint = _blueprint()
        self._actions = tuple(actions)

    def to_viewer(self, source: str) -> None:
        """Show it in a viewer that is open: see `rerun_viewer`."""
        self._stream.connect_grpc(source, default_blueprint=self._blueprint)
        self._furnish()

    def to_file(self, path: Path) -> None:
        """Write it to a file of Rerun's."""
        self._stream.save(path, default_blueprint=self._blueprint)
        self._furnish()

    def at(self, time_ns: int, tick: int | None) -> None:
        """Set the time of what comes next."""
        self._stream.set_time(TIME, timestamp=np.datetime64(time_ns, "ns"))
        if tick is not None:
            self._stream.set_time(TICK, sequence=tick)

    def draw(self, drawing: Drawing) -> None:
        """Draw it."""
        self._stream.log(drawing.place, _archetype(drawing))

    def fix(self, drawing: Drawing) -> None:
        """Draw it for all times."""
        self._stream.log(drawing.place, _archetype(drawing), static=True)

    def finish(self) -> None:
        """Send what is still held back."""
        self._stream.flush()

    def _furnish(self) -> None:
        """What is true at all times: which way is up, and what the curves are."""
        self._stream.send_recording_name(self._name)
        still = {"static": True}
        self._stream.log(draw.WORLD, rr.ViewCoordinates.RIGHT_HAND_Z_UP, **still)
        arrow = rr.Arrows3D(vectors=[[0.4, 0.0, 0.0]], radii=0.04, colors=[_ROBOT_COLOUR])
        self._stream.log(f"{draw.ROBOT}/ahead", arrow, **still)
        self._stream.log(draw.COMMAND, rr.SeriesLines(names=list(_SPEEDS)), **still)
        if self._actions:
            colours = [_ACTION_COLOURS[i % len(_ACTION_COLOURS)] for i in range(len(self._actions))]
            curves = rr.SeriesLines(names=list(self._actions), colors=colours)
            self._stream.log(draw.Q_VALUES, curves, **still)


def _archetype(drawing: Drawing) -> Any:
    match drawing:
        case draw.DrawnPicture():
            return rr.Image(drawing.pixels)
        case draw.DrawnFile():
            return rr.EncodedImage(contents=drawing.data, media_type=drawing.media_type)
        case draw.DrawnPoints():
            return rr.Points3D(drawing.points_m, radii=0.03, colors=[_SCAN_COLOUR])
        case draw.DrawnLine():
            thin = drawing.place == draw.WAY
            colour = _WAY_COLOUR if thin else _PATH_COLOUR
            radius_m = 0.01 if thin else 0.03
            return rr.LineStrips3D([drawing.points_m], radii=radius_m, colors=[colour])
        case draw.DrawnFrame():
            turn = rr.RotationAxisAngle(axis=[0, 0, 1], angle=rr.Angle(rad=drawing.heading_rad))
            return rr.Transform3D(translation=[drawing.x_m, drawing.y_m, 0.0], rotation=turn)
        case draw.DrawnNumbers():
            return rr.Scalars(drawing.values)
        case draw.DrawnWords():
            return rr.TextLog(drawing.text, level=drawing.level)
        case _:
            return _shape(drawing)


def _shape(drawing: draw.DrawnBoxes | draw.DrawnDiscs | draw.DrawnTriangles) -> Any:
    match drawing:
        case draw.DrawnBoxes():
            return rr.Boxes3D(
                centers=drawing.centres_m,
                sizes=drawing.sizes_m,
                colors=drawing.colours,
                fill_mode="solid",
            )
        case draw.DrawnDiscs():
            return rr.Cylinders3D(
                centers=drawing.centres_m,
                radii=drawing.radii_m,
                lengths=drawing.heights_m,
                colors=drawing.colours,
                fill_mode="solid",
            )
        case draw.DrawnTriangles():
            return rr.Mesh3D(vertex_positions=drawing.corners_m, vertex_colors=drawing.colours)


def _blueprint() -> Any:
    """The world beside retina, Q-values, command and events, with nothing else in the way."""
    beside = rrb.Vertical(
        rrb.Tabs(
            rrb.Spatial2DView(origin=draw.RETINA, name="Retina"),
            rrb.Spatial2DView(origin=draw.IMAGES, name="Images"),
        ),
        rrb.TimeSeriesView(origin=draw.Q_VALUES, name="Q-values"),
        rrb.TimeSeriesView(origin=draw.COMMAND, name="Command"),
        rrb.TextLogView(origin=draw.EVENTS, name="Verdicts and events"),
        row_shares=[1, 2, 2, 2],
    )
    return rrb.Blueprint(
        rrb.Horizontal(rrb.Spatial3DView(origin=draw.WORLD, name="World"), beside),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline=TIME),
    )
