import math

import numpy as np
import pytest

from reflexarc_sim_bridge.evaluation.metrics.switches import entropy_bits
from support.hand_tracks import figures, marks, track_of


def test_switches_and_reversals_by_hand() -> None:
    # stay, left, left, right, stay, stay, right, left, left, left in one second
    found = figures(track_of(10, actions=[0, 1, 1, 2, 0, 0, 2, 1, 1, 1]))
    assert found["switches_per_s"] == pytest.approx(5.0)
    assert found["reversals_per_s"] == pytest.approx(2.0)
    # Between two switches: left twice, right once, stay twice, right once.
    assert found["short_holds"] == pytest.approx(2 / 4)


def test_a_contact_is_no_switch_and_cuts_a_hold() -> None:
    actions = [0, 1, 1, 2, 2, 0, 0]
    found = figures(track_of(7, actions=actions, met=marks(7, 2)))
    assert found["switches_per_s"] == pytest.approx(2 / 0.7)
    assert found["reversals_per_s"] == 0.0
    assert math.isnan(found["short_holds"])  # the only holds are cut by the contact or the ends


def test_who_decides_otherwise_at_every_step_holds_nothing() -> None:
    found = figures(track_of(101, actions=np.arange(101) % 2))
    assert found["switches_per_s"] == pytest.approx(100 / 10.1)
    assert found["short_holds"] == 1.0


def test_who_never_changes_has_no_holds_and_no_entropy() -> None:
    found = figures(track_of(50))
    assert (found["switches_per_s"], found["action_bits"]) == (0.0, 0.0)
    assert math.isnan(found["short_holds"])


@pytest.mark.parametrize(
    ("counts", "bits"), [([4, 4], 1.0), ([5, 5, 5, 5], 2.0), ([0, 9], 0.0), ([1, 1, 2], 1.5)]
)
def test_entropy_in_closed_form(counts: list[int], bits: float) -> None:
    assert entropy_bits(np.array(counts, float)) == pytest.approx(bits)


def test_nothing_has_no_entropy() -> None:
    assert math.isnan(entropy_bits(np.zeros(3)))


def test_agents_do_not_share_their_holds() -> None:
    actions = np.array([[0, 1], [1, 1], [1, 0], [0, 0]])
    found = figures(track_of(4, 2, actions=actions))
    assert found["switches_per_s"] == pytest.approx(3 / 0.8)
    assert found["short_holds"] == 0.0  # one hold, of two steps
