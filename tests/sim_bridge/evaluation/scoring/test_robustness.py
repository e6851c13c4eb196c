import math

import pytest

from reflexarc_sim_bridge.evaluation.protocol.results import ResultRow
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.scoring.robustness import robustness_area


def rows(**scores: float) -> list[ResultRow]:
    return [
        ResultRow("x", Setting.FIELD, "robustness", tier, {"score": [score]})
        for tier, score in scores.items()
    ]


def score_of(row: ResultRow) -> float:
    return float(row.array("score")[0])


def test_it_is_the_mean_of_the_worse_over_the_score_as_it_is() -> None:
    assert robustness_area(rows(none=0.8, a=0.8, b=0.4, c=0.0), score_of) == pytest.approx(0.5)


def test_rows_of_other_families_do_not_count() -> None:
    other = ResultRow("x", Setting.FIELD, "discs", "a", {"score": [99.0]})
    assert robustness_area([*rows(none=0.5, a=0.5), other], score_of) == 1.0


@pytest.mark.parametrize("scores", [{}, {"none": 0.5}, {"a": 0.5}, {"none": 0.0, "a": 0.1}])
def test_with_nothing_to_compare_there_is_none(scores: dict[str, float]) -> None:
    assert math.isnan(robustness_area(rows(**scores), score_of))


def test_who_is_worse_than_blind_as_it_is_has_nothing_to_keep() -> None:
    assert math.isnan(robustness_area(rows(none=-0.2, a=-0.4), score_of))
