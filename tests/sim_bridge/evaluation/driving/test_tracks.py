"""What a drive writes down of the room around its agents."""

from dataclasses import replace

import numpy as np
import pytest

from reflexarc_sim_bridge.evaluation.driving.drive import drive
from reflexarc_sim_bridge.evaluation.metrics.track import Track
from reflexarc_sim_bridge.evaluation.protocol.contender import contender_of
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import suite_named
from reflexarc_sim_bridge.worlds.seeds import validation_seeds
from support.hand_tracks import figures

LITE = suite_named("lite")
SUITE = replace(LITE, worlds=4, lanes=16, free_paths=20.0)


def driven(family: str, name: str = "blind") -> Track:
    cell = LITE.only((family,)).families[0].cells[0]
    return drive(contender_of(name), cell, SUITE, Setting.FIELD, validation_seeds(4))


@pytest.mark.parametrize("family", ["rectangles", "outlines", "steps"])
def test_who_goes_straight_on_meets_what_was_ahead_when_it_was_said(family: str) -> None:
    """Obstacles at rest: the time ahead counts down by a step at each, and ends in a contact."""
    track = driven(family)
    dt_s, ahead_s, met = track.circumstances.dt_s, track.ahead_s, track.met
    assert met.sum() > 100
    assert (ahead_s[met] <= dt_s + 1e-5).all()
    assert met[ahead_s <= dt_s - 1e-5].all()
    goes_on = ~met[:-1] & np.isfinite(ahead_s[:-1])
    np.testing.assert_allclose(ahead_s[1:][goes_on], ahead_s[:-1][goes_on] - dt_s, atol=1e-4)


def test_clearance_never_exceeds_what_lies_ahead() -> None:
    track = driven("rectangles", "random")
    assert track.clearance_m.min() > 0.0
    assert track.clearance_m.max() <= track.circumstances.range_m
    way_m = track.ahead_s * track.circumstances.forward_mps
    assert (track.clearance_m <= way_m + 1e-4).all()


def test_who_never_steers_has_the_figures_of_theory() -> None:
    """One contact a mean free path, lives that are exponential, no threat avoided."""
    found = figures(driven("rectangles"))
    assert found["contacts_per_free_path"] == pytest.approx(1.0, abs=0.15)
    assert found["free_way"] == pytest.approx(1.0, abs=0.15)
    assert found["threat_avoidance"] == 0.0
    assert found["edge_index"] == pytest.approx(1.0, abs=0.35)
    assert found["switches_per_s"] == found["aside_per_ahead"] == 0.0
