"""The retina over time, and the retina now: the leftmost ray on top, brighter is a larger value."""

import numpy as np
import numpy.typing as npt
from matplotlib import colormaps
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.image import AxesImage
from matplotlib.ticker import MaxNLocator

from reflexarc_pictures.courses.course import Course, Snapshot
from reflexarc_pictures.log_pictures.decision_strips import INK, SAFE_COLOUR
from reflexarc_pictures.log_pictures.drive import CONTACT_COLOUR

_GREY = colormaps["magma"]


class RetinaStrip:
    """Draws the retinas of a course up to one snapshot.

    Args:
        over_time: axes for all retinas, one column each.
        now: axes for the newest retina.
        course: has the retinas.
    """

    def __init__(self, over_time: Axes, now: Axes, course: Course) -> None:
        self._course = course
        self._pixels = np.stack(
            [_column(snapshot, course) for snapshot in course.snapshots], axis=1
        )
        rows, columns, _ = self._pixels.shape
        begins_s = course.begins_s
        end_s = begins_s + columns * course.period_s
        self._strip = _image(over_time, self._pixels, (begins_s, end_s))
        self._now = _image(now, self._pixels[:, :1], (0.0, 1.0))
        self._met = over_time.vlines([], 0, rows, colors=CONTACT_COLOUR, linewidth=1.4)
        for axes, title in ((over_time, f"what it saw (bright: {course.bright})"), (now, "now")):
            axes.set_facecolor(SAFE_COLOUR if axes is now else "white")
            axes.set_title(title, loc="left", fontsize=9, color=INK)
            axes.tick_params(labelsize=8)
        now.set(xticks=[], yticks=[])
        over_time.set_xlabel("time (s)", fontsize=8.5)
        over_time.set_ylabel("ray (0: leftmost)", fontsize=8.5)
        over_time.yaxis.set_major_locator(MaxNLocator(3, integer=True))

    @property
    def artists(self) -> list[Artist]:
        """What changes from snapshot to snapshot."""
        return [self._strip, self._now, self._met]

    def show(self, k: int) -> None:
        """Show everything up to snapshot k."""
        shown = self._pixels.copy()
        shown[:, k + 1 :] = 0
        self._strip.set_data(shown)
        self._now.set_data(self._pixels[:, k : k + 1])
        course = self._course
        met_s = [course.begins_s + c * course.period_s for c in course.contacts if c <= k]
        rows = len(self._pixels)
        self._met.set_segments([np.array([(s, 0.0), (s, rows)]) for s in met_s])


def _image(axes: Axes, pixels: npt.NDArray[np.uint8], across: tuple[float, float]) -> AxesImage:
    extent = (*across, len(pixels), 0.0)
    return axes.imshow(pixels, aspect="auto", interpolation="nearest", extent=extent)


def _column(snapshot: Snapshot, course: Course) -> npt.NDArray[np.uint8]:
    """One pixel for each ray, RGB and opacity: (eyes · rays, 4); grey without a retina."""
    retina = snapshot.retina
    if retina is None:
        known = next((m.retina for m in course.snapshots if m.retina is not None), None)
        rows = 1 if known is None else known.shape[0] * known.shape[1]
        return np.tile(np.array([180, 188, 196, 255], np.uint8), (rows, 1))
    values = retina.reshape(-1, retina.shape[2])
    if values.shape[1] == 1:
        pixels: npt.NDArray[np.uint8] = _GREY(values[:, 0], bytes=True)
        return pixels
    return np.concatenate([values, np.full((len(values), 1), 255, np.uint8)], axis=1)
