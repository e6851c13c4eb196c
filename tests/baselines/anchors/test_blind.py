import pytest

from reflexarc_baselines.anchors.blind import Blind
from reflexarc_sim_bridge.evaluation.reference_field import measure


@pytest.mark.long
def test_it_makes_the_contacts_of_a_body_that_never_steers() -> None:
    """2ρR = 0.40 · 0.90 a metre."""
    score = measure(Blind(), Blind().contract, agents=256, steps=400)
    assert score.contacts_per_100m == pytest.approx(36.0, rel=0.05)
