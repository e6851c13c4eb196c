import dataclasses
import math
import re
from base64 import b64decode
from html.parser import HTMLParser
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread
from PIL import Image

from reflexarc_logs.judging.judgement import LogJudgement
from reflexarc_pictures.judgement_page.judged_page import judgement_page, write_judgement_page
from support.browser import opened, screenshot
from support.made_judgement import EVIL, made_flip, made_judgement, made_log

EMPTY = frozenset({"meta", "circle", "image", "line", "path", "polygon", "polyline", "rect"})


class Nesting(HTMLParser):
    """Fails where an element ends that is not the innermost one."""

    def __init__(self) -> None:
        super().__init__()
        self.inside: list[str] = []
        self.links: list[str] = []
        self.ids: list[str] = []
        self.tags: list[str] = []
        self.classes: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.inside.append(tag)
        self._note(tag, attrs)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert tag in EMPTY, tag
        self._note(tag, attrs)

    def handle_endtag(self, tag: str) -> None:
        assert self.inside.pop() == tag

    def _note(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.links += [value or "" for name, value in attrs if name in ("href", "src")]
        self.ids += [value or "" for name, value in attrs if name == "id"]
        self.classes += [value or "" for name, value in attrs if name == "class"]


def read(page: str) -> Nesting:
    reader = Nesting()
    reader.feed(page)
    assert reader.inside == []
    return reader


def test_a_real_browser_shows_every_log_and_complains_of_nothing(tmp_path: Path):
    logs = made_log(EVIL, 6), made_log("b.mcap", 0), LogJudgement(log="c", problem="no ticks")
    page = tmp_path / "page.html"
    write_judgement_page(made_judgement(*logs, candidate=EVIL), page)
    seen = opened(page, tmp_path / "profile")
    assert seen.complaints == []
    assert seen.scripts == 1
    assert [row[0] for row in seen.board] == [
        "<script>throw 1</script>[red]a\\x1b[31m/\\u202e&amp;'\".mcap",
        "b.mcap",
        "c",
    ]
    assert [row[2] for row in seen.board] == ["6", "0", ""]
    assert [row[8] for row in seen.board] == ["1 of 2", "1 of 2", ""]
    picture = tmp_path / "page.png"
    screenshot(page, picture, tmp_path / "profile")
    pixels = imread(picture)[..., :3]
    assert len(np.unique((pixels * 255).astype(int).reshape(-1, 3), axis=0)) > 50


@pytest.mark.parametrize("count", [0, 1, 30, 90])
@pytest.mark.parametrize("flips", [0, 1, 200])
def test_any_judgement_becomes_a_page_that_is_whole_bounded_and_needs_nothing_else(
    count: int, flips: int
):
    logs = [made_log(f"[b]log {k}", flips, more=flips) for k in range(count)]
    page = judgement_page(made_judgement(*logs))
    reader = read(page)
    assert all(link.startswith(("#", "data:image/png;")) for link in reader.links)
    assert {link[1:] for link in reader.links if link.startswith("#")} <= set(reader.ids)
    assert len(page.encode()) < 4_000_000
    assert not re.search(r"https?://|@import|url\(", page)
    assert not re.search(r"\b(nan|inf|None)\b", page)
    cards = reader.classes.count("card flip")
    assert cards == min(count, 60) * min(flips, 600 // max(1, min(count, 60)))


def test_what_is_not_drawn_is_said():
    page = judgement_page(made_judgement(made_log(flips=200, more=536)))
    assert "536 flips of smaller margins are not drawn" in page
    many = judgement_page(made_judgement(*[made_log(str(k), 1) for k in range(70)]))
    assert "10 more logs, the least bad, stand in the table alone" in many


def test_the_retina_of_a_flip_is_there_cell_by_cell():
    shape = (3, 2, 11, 3)
    log = made_log(flips=1, shape=shape)
    links = read(judgement_page(made_judgement(log))).links
    (address,) = [link for link in links if link.startswith("data:")]
    pixels = np.asarray(Image.open(BytesIO(b64decode(address.partition(",")[2]))))
    held = np.frombuffer(log.shown_flips[0].retina, np.uint8)
    np.testing.assert_array_equal(pixels, held.reshape(6, 11, 3))


def test_a_retina_of_another_size_than_said_is_left_out():
    log = dataclasses.replace(made_log(flips=2), retina_shape=(1, 1, 7, 1))
    page = judgement_page(made_judgement(log))
    assert "data:image" not in page
    assert page.count("no retina of this shape was kept") == 2


def test_q_values_that_are_no_numbers_are_said_so():
    flip = dataclasses.replace(
        made_flip(1), recorded_q_values=(math.nan, math.inf, -math.inf), margin=math.nan
    )
    page = judgement_page(made_judgement(dataclasses.replace(made_log(), shown_flips=(flip,))))
    assert page.count("not finite") == 5
    assert not re.search(r"\b(nan|inf)\b", page)


def test_the_longest_bar_is_the_greatest_q_value_and_the_least_has_none():
    flip = dataclasses.replace(
        made_flip(1),
        recorded=0,
        candidate=1,
        recorded_q_values=(4.0, 3.0, 2.0),
        candidate_q_values=(-1.0, 1.0, 0.0),
    )
    page = judgement_page(made_judgement(dataclasses.replace(made_log(), shown_flips=(flip,))))
    bars = re.findall(r'<rect class="bar( pale)?"[^>]*width="([\d.]+)"', page)
    assert [float(width) for _, width in bars] == [72.0, 36.0, 1.0, 1.0, 72.0, 36.0]
    assert [pale == "" for pale, _ in bars] == [True, False, False, False, True, False]


def test_of_flips_in_a_row_one_is_in_view_and_the_others_are_folded_away():
    row = tuple(
        dataclasses.replace(made_flip(1), tick=k, time_s=0.02 * k, margin=9.0 - 0.1 * k)
        for k in range(20)
    )
    log = dataclasses.replace(made_log(), shown_flips=row, flips=20)
    in_view, _, folded = judgement_page(made_judgement(log)).rpartition("<summary>")
    assert in_view.count("card flip") == 1
    assert folded.count("card flip") == 19


def test_the_same_judgement_gives_the_same_bytes():
    one, two = (judgement_page(made_judgement(made_log(flips=9))) for _ in range(2))
    assert one == two
    assert one != judgement_page(made_judgement(made_log(flips=8)))
