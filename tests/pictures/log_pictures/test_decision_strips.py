from pathlib import Path

import numpy as np
import pytest

from reflexarc_logs.reading.reader import read_log
from reflexarc_pictures.log_pictures.decision_strips import decisions_of


def test_what_was_decided_is_drawn_as_it_stands_in_the_log(turning: Path):
    log = read_log(turning)
    decisions, ticks = decisions_of(log), [tick.decision for tick in log.ticks()]
    assert decisions.actions.tolist() == [tick.action for tick in ticks]
    assert decisions.time_s[-1] == pytest.approx((ticks[-1].now_ns - ticks[0].now_ns) / 1e9)
    for row, values, tick in zip(decisions.retinas, decisions.q_values, ticks, strict=True):
        if tick.retina:
            assert bytes(row.astype(np.uint8)) == tick.retina
            assert values.tolist() == list(tick.q_values)
        else:
            assert np.isnan([*row, *values]).all()
