import json
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from reflexarc_pictures.suite_page.from_results import content_of, draw_results, read_results
from reflexarc_pictures.suite_page.markup import element, text
from reflexarc_pictures.suite_page.page import page_text
from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.evaluation.protocol.results import Results
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from support.browser import opened, screenshot
from support.page_results import page_results

EVIL = "<script>throw 1</script>"
NAMES = [EVIL, "a\"b'c&amp;", "runs/" + "long-" * 20 + "name.onnx", "turned \u202e round", "rover"]
MOST_BYTES = 2_000_000
EMPTY = frozenset({"meta", "circle", "image", "line", "path", "polygon", "polyline", "rect"})


def page_of(results: Results) -> str:
    return page_text(content_of(results))


class Nesting(HTMLParser):
    """Fails where an element ends that is not the innermost one."""

    def __init__(self) -> None:
        super().__init__()
        self.inside: list[str] = []
        self.links: list[str] = []
        self.ids: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.inside.append(tag)
        self._note(attrs)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        assert tag in EMPTY, tag
        self._note(attrs)

    def handle_endtag(self, tag: str) -> None:
        assert self.inside.pop() == tag

    def _note(self, attrs: list[tuple[str, str | None]]) -> None:
        self.links += [value or "" for name, value in attrs if name in ("href", "src")]
        self.ids += [value or "" for name, value in attrs if name == "id"]


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "page.html"
    path.write_text(page_of(page_results(NAMES, turns=["rover"])))
    return path


def test_a_real_browser_shows_every_contender_and_complains_of_nothing(page: Path, tmp_path: Path):
    seen = opened(page, tmp_path / "profile")
    assert seen.title == "reflexarc made-up-1"
    assert seen.complaints == []
    assert [row[0] for row in seen.board] == ["1", "2", "3", "4", "5"]
    names = {row[1] for row in seen.board}
    assert names == {*NAMES[:3], "turned \\u202e round", "rover"}
    assert seen.scripts == 1


def test_a_click_on_a_heading_sorts_the_board(page: Path, tmp_path: Path):
    clicked = tmp_path / "clicked.html"
    click = "<script>document.querySelectorAll('#board thead th')[5].click()</script></body>"
    clicked.write_text(page.read_text().replace("</body>", click))
    board = opened(clicked, tmp_path / "profile").board
    contacts = [float(row[5]) for row in board if row[5] != "\u2013"]
    assert contacts == sorted(contacts, reverse=True)
    assert [row[5] for row in board].count("\u2013") == 1


def test_a_browser_that_complains_is_heard(page: Path, tmp_path: Path):
    broken = tmp_path / "broken.html"
    broken.write_text(page.read_text().replace("</body>", "<script>none.such()</script></body>"))
    assert "none is not defined" in opened(broken, tmp_path / "profile").complaints[0]


def test_there_is_something_to_see(page: Path, tmp_path: Path):
    picture = tmp_path / "page.png"
    screenshot(page, picture, tmp_path / "profile")
    pixels = imread(picture)[..., :3]
    assert pixels.shape[:2] == (2000, 1300)
    assert len(np.unique((pixels * 255).astype(int).reshape(-1, 3), axis=0)) > 50
    assert 0.02 < (pixels.mean(axis=2) < 0.8).mean() < 0.8


@pytest.mark.parametrize("count", [1, 2, 7, 40])
@pytest.mark.parametrize("bare", [False, True])
@pytest.mark.parametrize("all_turn", [False, True])
def test_any_results_become_a_page_that_is_whole_and_needs_nothing_else(
    count: int, bare: bool, all_turn: bool
):
    names = [f"policy {k}" for k in range(count)]
    results = page_results(names, turns=names if all_turn else (), bare=bare)
    shown = page_of(results)
    reader = Nesting()
    reader.feed(shown)
    assert reader.inside == []
    assert all(link.startswith(("#", "data:image/png;")) for link in reader.links)
    assert {link[1:] for link in reader.links if link.startswith("#")} <= set(reader.ids)
    assert len(shown.encode()) < MOST_BYTES
    assert not re.search(r"https?://|@import|url\(", shown)
    assert not re.search(r"\b(nan|inf|None)\b", shown)


def test_the_same_results_give_the_same_bytes():
    results = page_results(NAMES)
    again = Results.from_json(json.loads(json.dumps(results.to_json())))
    assert page_of(results) == page_of(again)
    assert page_of(results) != page_of(page_results(NAMES, version="1.2.4"))


def test_one_setting_is_enough():
    shown = page_of(page_results(["a", "b"], settings=[Setting.FIELD]))
    assert "score, field" in shown
    assert "score, robot" not in shown
    assert "evaluate runs/a runs/b --suite made-up --setting field" in shown


def test_text_is_never_markup():
    attribute = element("p", EVIL, title='"><script>')
    assert attribute == (
        '<p title="&quot;&gt;&lt;script&gt;">&lt;script&gt;throw 1&lt;/script&gt;</p>'
    )
    assert text("a\x00b\u202ec") == "a\\x00b\\u202ec"


def test_nobody_measured_is_refused():
    with pytest.raises(UsageError, match="one contender or more"):
        page_of(page_results([]))


def test_results_become_a_page_or_a_picture_of_the_scores(tmp_path: Path):
    results = tmp_path / "results.json"
    results.write_text(json.dumps(page_results(NAMES, turns=["rover"]).to_json()))
    draw_results(read_results(results), tmp_path / "page.html")
    assert (tmp_path / "page.html").read_text().startswith("<!doctype html>")
    pictures = [tmp_path / "one.png", tmp_path / "two.png"]
    for picture in pictures:
        draw_results(read_results(results), picture)
    assert pictures[0].read_bytes() == pictures[1].read_bytes()
    assert len(np.unique(imread(pictures[0]).reshape(-1, 4), axis=0)) > 50


@pytest.mark.parametrize("wrong", ["", "[]", "{}", '{"suite": 1}', "\x00"])
def test_what_are_no_results_are_refused_by_name(wrong: str, tmp_path: Path):
    path = tmp_path / "results.json"
    path.write_text(wrong)
    with pytest.raises(UsageError, match=r"results\.json: expected results of a suite"):
        read_results(path)
