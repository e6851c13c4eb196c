"""What is kept on disk is right, whole, or computed anew."""

import pytest

from reflexarc_sim_bridge.evaluation.limits import kept as module
from reflexarc_sim_bridge.evaluation.limits.kept import kept


class Counted:
    def __init__(self):
        self.calls = 0

    def __call__(self):
        self.calls += 1
        return [0.1 + self.calls, 1e-300]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setattr(module, "cache_folder", lambda: tmp_path)
    return tmp_path


def test_the_same_question_is_computed_once_and_another_one_anew(folder):
    compute = Counted()
    assert kept((1.0, "a"), compute) == kept((1.0, "a"), compute) == [1.1, 1e-300]
    assert kept((1.0000000000000002, "a"), compute) == [2.1, 1e-300]
    assert compute.calls == 2


@pytest.mark.parametrize("content", [b"", b"[1.1, 1", b"[1, 2]", b'{"a": 1.0}', b"\xff", b"[NaN"])
def test_what_was_damaged_is_computed_anew_and_mended(folder, content):
    compute = Counted()
    kept(1, compute)
    (path,) = folder.glob("limits/*.json")
    path.write_bytes(content)
    assert kept(1, compute) == [2.1, 1e-300]
    assert kept(1, compute) == [2.1, 1e-300]


def test_other_sources_have_other_files(folder, monkeypatch):
    compute = Counted()
    kept(1, compute)
    monkeypatch.setattr(module, "source_key", lambda _: "other")
    assert kept(1, compute) == [2.1, 1e-300]


def test_without_a_folder_everything_is_computed(monkeypatch):
    monkeypatch.setattr(module, "cache_folder", lambda: None)
    compute = Counted()
    assert [kept(1, compute)[0], kept(1, compute)[0]] == [1.1, 2.1]


def test_a_folder_that_cannot_be_written_is_no_error(folder):
    (folder / "limits").write_text("a file where the folder should be")
    compute = Counted()
    assert [kept(1, compute)[0], kept(1, compute)[0]] == [1.1, 2.1]
