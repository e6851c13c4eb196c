"""Which logs a project names, and which of them a run of its tests should reach."""

import os
from pathlib import Path

import pytest

from reflexarc_logs.named_logs import LogNet, NetError, WhatRuns, followed, named_logs


@pytest.fixture
def root(tmp_path: Path) -> Path:
    for name in ("a/one.mcap", "a/deep/TWO.MCAP", "a/notes.txt", "b/golden/three.mcap"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    return tmp_path


@pytest.mark.parametrize(
    ("place", "names"),
    [
        ("a", ["a/deep/TWO.MCAP", "a/one.mcap"]),
        ("a/", ["a/deep/TWO.MCAP", "a/one.mcap"]),
        ("a/deep/..", ["a/deep/TWO.MCAP", "a/one.mcap"]),
        ("a/one.mcap", ["a/one.mcap"]),
        ("*/golden", ["b/golden/three.mcap"]),
    ],
)
def test_a_place_is_a_folder_a_log_or_a_pattern(place, names, root):
    assert sorted(named_logs(root, [place])) == [root / name for name in names]


@pytest.mark.parametrize("place", ["c", "a/notes.txt", "*.mcap", "/nowhere/*", ""])
def test_a_place_without_a_log_is_an_error(place, root):
    empty = root / "empty"
    empty.mkdir()
    with pytest.raises(NetError):
        named_logs(empty if not place else root, [place])


def test_a_link_that_leads_back_ends(root):
    (root / "a/deep/up").symlink_to("..")
    assert len(named_logs(root, ["a"])) == 2


def test_a_log_counts_as_reached_by_any_name_of_it(root):
    (root / "link.mcap").symlink_to("a/one.mcap")
    net = LogNet(named_logs(root, ["a/one.mcap"]))
    assert net.take(root / "link.mcap")
    assert not net.take(root / "b/golden/three.mcap")
    assert net.left == []


def test_only_what_a_run_should_reach_and_nobody_left_out_is_missing(root):
    log = root / "a/one.mcap"

    def missing(**run: object) -> bool:
        told = {"places": [], "is_whole": False, **run}
        return bool(list(LogNet([log]).unreached(WhatRuns(**told))))  # type: ignore[arg-type]

    assert missing(is_whole=True)
    assert missing(places=[root / "a"])
    assert missing(places=[log])
    assert not missing(places=[root / "b"])
    assert not missing(is_whole=True, ignored=[root / "a"])
    assert not missing(is_whole=True, ignored_patterns=[f"{root}/*/one*"])
    assert missing(is_whole=True, ignored=[root / "b"], ignored_patterns=["*.txt"])


@pytest.mark.parametrize(
    "text", ["one.mcap", "nowhere.mcap", "one.mcap\n", "../" * 2000 + "a.mcap"]
)
def test_only_a_file_of_text_that_names_a_log_is_followed(text, root):
    link = root / "a/link.mcap"
    link.write_text(text)
    expected = root / "a/one.mcap" if text == "one.mcap" else link
    assert followed(link) == expected
    assert os.path.samefile(followed(link), expected)
