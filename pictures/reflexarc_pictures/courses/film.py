"""Makes a film of a course: the view from above follows the agent, with its retinas below.

What never changes is drawn once; each frame draws what moves on top of it. A GIF has one palette
for all frames, without dithering: equal colours stay equal, and the file stays small. An MP4 is
made by ffmpeg, if that is installed.
"""

import contextlib
import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

from matplotlib.artist import Artist
from matplotlib.figure import Figure
from PIL import Image

from reflexarc_pictures.courses.canvas import Canvas
from reflexarc_pictures.courses.course import Course
from reflexarc_pictures.courses.retina_strip import RetinaStrip
from reflexarc_pictures.courses.top_view import TopView
from reflexarc_pictures.log_pictures.decision_strips import INK
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.words.shown import plain
from reflexarc_sim_bridge.worlds.silhouettes import Area

RATE_HZ = 10.0
WIDTH_IN, HEIGHT_IN, DPI = 6.0, 5.4, 100
NOSE_M = 0.28
MOST_COLOURS = 96
LEAST_RANGE_M, MOST_RANGE_M = 2.0, 20.0
"""Bounds of the range that sets the scale, whatever the eye's own range is."""
BEHIND, AHEAD = 0.7, 1.42
"""What is shown behind and ahead, as a multiple of the eye's range."""

_MAP, _STRIP, _NOW = (
    (0.0, 0.25, 1.0, 0.705),
    (0.085, 0.085, 0.82, 0.115),
    (0.93, 0.085, 0.05, 0.115),
)
"""Left, bottom, width, height of each, as shares of the figure."""
_SLOPE = _MAP[3] * HEIGHT_IN / (_MAP[2] * WIDTH_IN)
_SAMPLES = 4
"""The palette is made of so many frames at equal intervals."""

ReportProgress = Callable[[int, int], None]


class Frames:
    """The frames of a course, drawn one after the other on one figure."""

    def __init__(self, course: Course) -> None:
        self._course, self.stride = course, max(round(1.0 / RATE_HZ / course.period_s), 1)
        figure = Figure((WIDTH_IN, HEIGHT_IN), dpi=DPI)
        self._canvas = Canvas(figure)
        above, strip, now = (figure.add_axes(place) for place in (_MAP, _STRIP, _NOW))
        above.set(xticks=[], yticks=[])
        self._view = TopView(above, course, NOSE_M)
        self._strip = RetinaStrip(strip, now, course)
        figure.text(0.012, 0.977, plain(course.title), color=INK, va="center", parse_math=False)
        self._facts = figure.text(0.988, 0.977, "", color=INK, va="center", ha="right")
        self._moving: list[Artist] = [*self._view.artists, *self._strip.artists, self._facts]
        for artist in self._moving:
            artist.set_animated(True)
        self._bring_to(0)  # axes take their size from what they show
        self._canvas.draw()

    def __len__(self) -> int:
        return (len(self._course.snapshots) - 1) // self.stride + 1

    @property
    def rate_hz(self) -> float:
        """Frames a second."""
        return 1.0 / (self.stride * self._course.period_s)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in pixels."""
        return self._canvas.size

    def image(self, number: int) -> Image.Image:
        """A frame in full colour."""
        self._bring_to(number * self.stride)
        self._canvas.draw_over(self._moving)
        return self._canvas.image()

    def _bring_to(self, k: int) -> None:
        course = self._course
        snapshot, met = course.snapshots[k], sum(c <= k for c in course.contacts)
        self._view.show(k, _area(course, k))
        self._strip.show(k)
        ahead_m = snapshot.x_m - course.snapshots[0].x_m
        contacts = f"{met} contact{'' if met == 1 else 's'}"
        self._facts.set_text(f"{k * course.period_s:.1f} s   {ahead_m:.1f} m   {contacts}")


def write_gif(course: Course, path: Path, progress: ReportProgress = lambda done, of: None) -> int:
    """Write an endless GIF; returns the number of frames."""
    frames = Frames(course)
    palette = _palette(frames)

    def drawn() -> Iterator[Image.Image]:
        for number in range(len(frames)):
            yield frames.image(number).quantize(palette=palette, dither=Image.Dither.NONE)
            progress(number + 1, len(frames))

    images, duration_ms = drawn(), round(1000 / frames.rate_hz)
    next(images).save(
        path,
        format="GIF",
        save_all=True,
        append_images=images,
        duration=duration_ms,
        loop=0,
        optimize=True,
    )
    return len(frames)


def write_mp4(course: Course, path: Path, progress: ReportProgress = lambda done, of: None) -> int:
    """Write an MP4 with ffmpeg; returns the number of frames.

    Raises:
        UsageError: there is no ffmpeg, or it failed.
    """
    check_ffmpeg()
    frames = Frames(course)
    with subprocess.Popen(
        _ffmpeg_words(frames, path), stdin=subprocess.PIPE, stderr=subprocess.PIPE
    ) as ffmpeg:
        assert ffmpeg.stdin is not None
        with contextlib.suppress(BrokenPipeError):  # ffmpeg ended early; its message follows
            for number in range(len(frames)):
                ffmpeg.stdin.write(frames.image(number).tobytes())
                progress(number + 1, len(frames))
        _, complaint = ffmpeg.communicate()
    if ffmpeg.returncode != 0:
        lines = complaint.decode(errors="replace").strip().splitlines() or ["no reason given"]
        raise UsageError(f"--out: ffmpeg failed: {lines[-1][:200]}; give a .gif")
    return len(frames)


def check_ffmpeg() -> None:
    """Check that ffmpeg is there to write an MP4.

    Raises:
        UsageError: no ffmpeg on the PATH.
    """
    if shutil.which("ffmpeg") is None:
        raise UsageError("--out: an MP4 needs ffmpeg, which is not on the PATH; give a .gif")


def _ffmpeg_words(frames: Frames, path: Path) -> list[str]:
    """Command line of ffmpeg: raw frames on standard input, colours as all players know them."""
    width, height = frames.size
    taken = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}"]
    rate = ["-r", f"{frames.rate_hz:g}"]
    made = ["-pix_fmt", "yuv420p", "-movflags", "+faststart", "-f", "mp4"]
    return ["ffmpeg", "-y", "-loglevel", "error", *taken, *rate, "-i", "-", *made, f"file:{path}"]


def _palette(frames: Frames) -> Image.Image:
    """A palette of colours for all frames."""
    last = len(frames) - 1
    numbers = sorted({round(last * k / (_SAMPLES - 1)) for k in range(_SAMPLES)})
    images = [frames.image(number) for number in numbers]
    width, height = frames.size
    together = Image.new("RGB", (width, height * len(images)))
    for k, image in enumerate(images):
        together.paste(image, (0, k * height))
    return together.quantize(MOST_COLOURS, dither=Image.Dither.NONE)


def _area(course: Course, k: int) -> Area:
    """What a frame shows around the agent."""
    snapshot = course.snapshots[k]
    range_m = min(max(course.eye.range_m, LEAST_RANGE_M), MOST_RANGE_M)
    aside_m = (BEHIND + AHEAD) * range_m * _SLOPE / 2
    return Area(
        snapshot.x_m - BEHIND * range_m,
        snapshot.x_m + AHEAD * range_m,
        snapshot.y_m - aside_m,
        snapshot.y_m + aside_m,
    )
