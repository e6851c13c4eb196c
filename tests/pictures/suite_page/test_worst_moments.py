import shlex
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from reflexarc.main import main
from reflexarc_pictures.suite_page.page import page_text
from reflexarc_pictures.suite_page.page_content import PageContent
from reflexarc_pictures.suite_page.worst_moments import worst_contact, worst_moments
from reflexarc_sim_bridge.evaluation.driving.drive import drive, extent_of
from reflexarc_sim_bridge.evaluation.protocol.entrant import Entrant
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import suite_named
from reflexarc_sim_bridge.evaluation.running.evaluate import evaluate
from reflexarc_sim_bridge.evaluation.scoring.suite_scores import score_cards
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from reflexarc_sim_bridge.worlds.seeds import test_seeds
from support.hand_tracks import marks, track_of
from support.policies import exported

SUITE = """
name = "small"
version = 1
worlds = 2
lanes = 2
free_paths = 3

[[families]]
name = "things"

[[families.cells]]
tier = "a/b: c"
world = "reference-1"
clutter = 0.2

[[families.cells]]
tier = "crossing"
world = "crossing"
"""


def test_what_was_seen_coming_for_longest_is_the_worst():
    steps = 30
    ahead_s = np.full((steps, 3), np.inf)
    ahead_s[:, 0] = 0.05  # always something else, never nearer
    ahead_s[4:12, 1] = 0.1 * np.arange(8, 0, -1)  # eight looks at one thing that comes nearer
    ahead_s[20:26, 2] = 0.1 * np.arange(6, 0, -1)
    met = np.stack([marks(steps, 3), marks(steps, 11), marks(steps, 25)], axis=1)
    worst = worst_contact(track_of(steps, 3, ahead_s=ahead_s, met=met))
    assert worst is not None
    assert (worst.agent, worst.step, worst.warning_steps) == (1, 11, 7)


def test_without_a_look_ahead_the_first_contact_is_taken_and_without_a_contact_none():
    met = np.stack([marks(30, 20), marks(30, 7, 25)], axis=1)
    worst = worst_contact(track_of(30, 2, met=met))
    assert worst is not None
    assert (worst.agent, worst.step, worst.warning_steps) == (1, 7, 0)
    assert worst_contact(track_of(30)) is None


def test_a_new_place_after_a_contact_is_no_warning_of_the_next():
    ahead_s = 0.1 * np.arange(12, 0, -1)
    worst = worst_contact(track_of(12, ahead_s=ahead_s, met=marks(12, 5, 11)))
    assert worst is not None
    assert (worst.step, worst.warning_steps) == (5, 5)


@pytest.mark.long
def test_the_command_under_a_moment_drives_to_the_very_contact_that_the_suite_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.chdir(tmp_path)
    Path("small.toml").write_text(SUITE)
    Path("my policy.onnx").write_bytes(exported(reference_contract(), seed=1))
    suite = suite_named("./small.toml")
    results = evaluate("my policy.onnx", suite, settings=(Setting.ROBOT,), jobs=1)
    cards = score_cards(results)
    entrant = Entrant("my policy.onnx", "my policy.onnx")
    moments = worst_moments(entrant, cards[0], suite, "./small.toml")
    assert 1 <= len(moments) <= 2
    for moment in moments:
        cell = suite.cell(f"{moment.family}/{moment.tier}")
        track = drive(entrant.contender(), cell, suite, moment.setting)
        step = moment.step - extent_of(track.circumstances, suite).discarded
        agent = test_seeds(2).tolist().index(moment.seed) * suite.lanes + moment.lane
        assert track.met[step, agent]
        last = moment.course.snapshots[-2]
        assert last.x_m == track.x_m[step, agent]
        assert last.y_m % track.circumstances.width_m == pytest.approx(track.y_m[step, agent])
        assert moment.at_s == pytest.approx((moment.step + 1) * track.circumstances.dt_s)
        assert main(shlex.split(moment.command)[1:]) == 0
        assert len(np.unique(imread("moment.png").reshape(-1, 4), axis=0)) > 30
    shown = page_text(PageContent(results, cards, suite, moments))
    assert shown.count("data:image/png;base64,") == len(moments)
    assert "&#x27;my policy.onnx&#x27;" in shown
