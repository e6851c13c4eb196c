import itertools

import pytest

from reflexarc_sim_bridge.evaluation.driving.decision_times import BATCH, decision_times
from reflexarc_sim_bridge.evaluation.protocol.contender import contender_of


def test_durations_of_a_clock_by_hand_give_their_percentiles() -> None:
    """The clock is asked twice a decision: each takes as long as one call of it adds."""
    ticks = itertools.count()

    def now_s() -> float:
        return 0.001 * next(ticks)

    times = decision_times(contender_of("blind"), decisions=100, now_s=now_s)
    assert times.p50_us == pytest.approx(1000.0)
    assert times.p99_us == pytest.approx(1000.0)
    assert times.decisions_per_s == pytest.approx(BATCH / 0.001)
