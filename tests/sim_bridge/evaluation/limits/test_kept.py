"""What is kept on disk is right, whole, or computed anew."""

import pytest

from reflexarc_sim_bridge.evaluation.limits import kept as module
from reflexarc_sim_bridge.evaluation.limits.kept import kept
from reflexarc_sim_bridge.evaluation.limits.oracle import depends_on, least_contacts
from reflexarc_sim_bridge.evaluation.limits.shipping import units_to_ship
from reflexarc_sim_bridge.evaluation.protocol.contender import Contender
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy

ROBOT = Setting.ROBOT
CHEAP_TIERS = "slippery", "polygons"


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


def test_what_ships_is_what_is_computed():
    """Of two cells that are cheap, at both rates; the rest has the same code and the same file."""
    cheap = [
        unit for unit in units_to_ship() if unit[1].name == "lite" and unit[0].tier in CHEAP_TIERS
    ]
    assert len(cheap) == 4
    for cell, suite, contract in cheap:
        body = Contender("point", BlindPolicy(3), contract)
        asked = depends_on(body, cell, suite, Setting.ROBOT)
        shipped = module.shipped_figures()[module.shipped_key(asked.text)]
        anew = [least_contacts(*world, contract, asked.extent) for world in asked.worlds[:2]]
        assert shipped[:2] == pytest.approx(anew, rel=1e-12, abs=1e-12)


def test_all_of_the_shipped_suites_is_there():
    keys = {
        module.shipped_key(
            depends_on(Contender("point", BlindPolicy(3), contract), cell, suite, ROBOT).text
        )
        for cell, suite, contract in units_to_ship()
    }
    assert keys == set(module.shipped_figures())


def test_another_generator_or_another_question_is_not_answered_by_what_ships(monkeypatch):
    key = module.shipped_key((1.0, "a"))
    assert key != module.shipped_key((1.0000000000000002, "a"))
    monkeypatch.setattr(module, "GENERATOR_VERSION", 99)
    assert key != module.shipped_key((1.0, "a"))
