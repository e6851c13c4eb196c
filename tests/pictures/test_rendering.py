from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from reflexarc_pictures.rendering import (
    DrawnPart,
    check_format,
    check_place,
    render_log,
    render_world,
)
from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.worlds.files import WORLDS

HALF_A_SECOND = DrawnPart(duration_s=0.5)


class Bars:
    """Progress bars that note what they show."""

    def __init__(self) -> None:
        self.shown: dict[str, list[tuple[int, int]]] = {}

    @contextmanager
    def bar(self, title: str, total: int) -> Iterator[Callable[[int, int], None]]:
        shown = self.shown.setdefault(title, [])
        yield lambda done, of: shown.append((done, of))


def test_progress_bars_show_the_drive_and_then_the_film_to_their_ends(tmp_path: Path):
    bars = Bars()
    film = tmp_path / "plane.gif"
    made = render_world(WORLDS["plane"], film, part=HALF_A_SECOND, progress_bar=bars.bar)
    assert list(bars.shown) == ["driving in plane", "drawing plane.gif"]
    for shown in bars.shown.values():
        assert [done for done, _ in shown] == list(range(1, len(shown) + 1))
        assert shown[-1][0] == shown[-1][1]
    assert (made.frames, made.bytes) == (len(shown), film.stat().st_size)


def test_without_progress_bars_nothing_is_printed(
    tmp_path: Path, turning: Path, capfd: pytest.CaptureFixture[str]
):
    render_world(WORLDS["plane"], tmp_path / "plane.gif", part=HALF_A_SECOND)
    render_log(turning, tmp_path / "turning.png")
    assert capfd.readouterr() == ("", "")


def test_a_file_that_cannot_be_written_is_refused_before_any_work(tmp_path: Path):
    for name in ("a.jpg", "a"):
        with pytest.raises(UsageError, match="expected a name that ends in"):
            check_format(tmp_path / name)
    with pytest.raises(UsageError, match="got the folder"):
        check_place(tmp_path)
    with pytest.raises(UsageError, match="no such folder"):
        check_place(tmp_path / "none" / "a.png")
