"""Renders worlds, logs and results as files: pictures (PNG), films (GIF, MP4), pages (HTML)."""

from collections.abc import Callable, Collection, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypeAlias

from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.files import whole_file

if TYPE_CHECKING:
    from reflexarc_pictures.courses.course import Course
    from reflexarc_pictures.log_pictures.log_picture import Kind
    from reflexarc_sim_bridge.evaluation.protocol.contender import Contender
    from reflexarc_sim_bridge.worlds.world import WorldSource

PICTURE, GIF, MP4, PAGE = ".png", ".gif", ".mp4", ".html"
FILM_S, STRETCH_S = 10.0, 20.0
"""Default duration of a film, and of a drive that becomes a picture."""

What: TypeAlias = Literal["stretch", "drive", "floor", "film", "page", "scores"]

ProgressBar: TypeAlias = Callable[[str, int], AbstractContextManager[Callable[[int, int], None]]]
"""Opens a progress bar with a title and a total; it yields what is called with (done, total)."""


@contextmanager
def no_progress_bar(title: str, total: int) -> Iterator[Callable[[int, int], None]]:
    """A progress bar that shows nothing."""
    yield lambda done, of: None


@dataclass(frozen=True)
class Rendered:
    """The file that was written."""

    picture: Path
    kind: What
    bytes: int
    frames: int
    """Number of frames of a film; 1 for a picture."""


@dataclass(frozen=True)
class DrawnPart:
    """Which drive through a world is drawn, and what of it."""

    seed: int = 0
    """Which of the world's variants, 0 to 2⁶⁴ − 1."""
    lane: int = 0
    """Which of the agents that share the world; they start apart."""
    from_s: float = 0.0
    """What is driven before, in the world's time."""
    duration_s: float | None = None
    """How long it is, likewise; None: `FILM_S` or `STRETCH_S`."""


def check_format(out: Path) -> None:
    """Check that a file of this format can be written.

    Raises:
        UsageError: another suffix, or an MP4 without ffmpeg.
    """
    if out.suffix.lower() not in (PICTURE, GIF, MP4):
        raise UsageError(f"--out: expected a name that ends in .png, .gif or .mp4, got {out}")
    if out.suffix.lower() == MP4:
        from reflexarc_pictures.courses.film import check_ffmpeg

        check_ffmpeg()


def check_results_format(out: Path) -> None:
    """Check that results of a suite can be written in this format.

    Raises:
        UsageError: another suffix.
    """
    if out.suffix.lower() not in (PAGE, PICTURE):
        raise UsageError(f"--out: expected a name that ends in .html or .png, got {out}")


def check_place(out: Path) -> None:
    """Check that a file can be written at a path, before any work is done for it.

    Raises:
        UsageError: its folder is missing, or it is a folder itself.
    """
    if out.is_dir():
        raise UsageError(f"--out: expected the name of a file, got the folder {out}")
    if not out.parent.is_dir():
        raise UsageError(f"--out: {out}: no such folder: {out.parent}; make it first")


def render_world(
    source: "WorldSource",
    out: Path | str,
    contender: "Contender | None" = None,
    part: DrawnPart = DrawnPart(),
    progress_bar: ProgressBar = no_progress_bar,
) -> Rendered:
    """Let an agent drive in a world, and draw the drive.

    Args:
        source: the world.
        out: PNG: the whole stretch; GIF or MP4: a film.
        contender: who drives; None: an agent that never steers, with the reference eye.
        part: which drive, and what of it.
        progress_bar: shows how far the drive and the film are.

    Raises:
        WorldError: the world does not support the contender's contract.
        UsageError: ffmpeg is needed and failed.
    """
    from reflexarc_pictures.courses.world_course import drive_in_world
    from reflexarc_sim_bridge.evaluation.protocol.contender import BLIND, contender_of

    out = Path(out)
    is_picture = out.suffix.lower() == PICTURE
    with progress_bar(f"driving in {source.name}", 1) as progress:
        course = drive_in_world(
            source,
            contender or contender_of(BLIND),
            part.seed,
            part.duration_s or (STRETCH_S if is_picture else FILM_S),
            progress,
            lane=part.lane,
            from_s=part.from_s,
        )
    if not is_picture:
        return _film(course, out, progress_bar)
    from reflexarc_pictures.courses.stretch import draw_stretch

    with whole_file(out) as unfinished:
        draw_stretch(course, unfinished)
    return Rendered(out, "stretch", out.stat().st_size, 1)


def render_results(
    path: Path | str,
    out: Path | str,
    suite: str = "",
    progress_bar: ProgressBar = no_progress_bar,
    code: Collection[str] = (),
) -> Rendered:
    """Draw the results of a suite: as a page (HTML), or as a picture (PNG).

    Args:
        path: `results.json` of `reflexarc evaluate --suite`.
        out: the page, or the picture.
        suite: its name or file; empty: the shipped one that the results name.
        progress_bar: shows how far the drives of the worst moments are.
        code: sources of code, module:Class, that may be run to draw those moments. Whatever else
            the results name is not.

    Raises:
        UsageError: these are no results of a suite.
    """
    from reflexarc_pictures.suite_page.from_results import draw_results, read_results

    out = Path(out)
    results = read_results(Path(path))
    with progress_bar("driving to the worst moments", 1) as progress:
        draw_results(results, out, suite, progress, code)
    is_page = out.suffix.lower() == PAGE
    return Rendered(out, "page" if is_page else "scores", out.stat().st_size, 1)


def render_log(
    path: Path | str,
    out: Path | str,
    kind: "Kind" = "auto",
    duration_s: float | None = None,
    progress_bar: ProgressBar = no_progress_bar,
) -> Rendered:
    """Draw a log of `reflexarc run --record`: a PNG shows all of it, a film its first seconds.

    Args:
        path: the log.
        out: the picture or the film.
        kind: which picture of a log; "auto": what its streams allow.
        duration_s: of a film; None: `FILM_S`.
        progress_bar: shows how far the film is.

    Raises:
        LogError: the log cannot be read, or there is nothing in it to draw.
        UsageError: the log lacks streams that the kind of picture needs; or ffmpeg failed.
    """
    path, out = Path(path), Path(out)
    if out.suffix.lower() == PICTURE:
        from reflexarc_pictures.log_pictures.log_picture import draw_log

        with whole_file(out) as unfinished:
            made = draw_log(path, unfinished, kind)
        return Rendered(out, made, out.stat().st_size, 1)
    from reflexarc_logs.reading.reader import read_log
    from reflexarc_pictures.courses.log_course import course_of

    return _film(course_of(read_log(path), duration_s or FILM_S), out, progress_bar)


def _film(course: "Course", out: Path, progress_bar: ProgressBar) -> Rendered:
    from reflexarc_pictures.courses.film import write_gif, write_mp4

    write = write_mp4 if out.suffix.lower() == MP4 else write_gif
    with progress_bar(f"drawing {out.name}", 1) as progress, whole_file(out) as unfinished:
        frames = write(course, unfinished, progress)
    return Rendered(out, "film", out.stat().st_size, frames)
