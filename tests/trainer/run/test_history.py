"""Validation points: the best one, and whether a goal is reached."""

import math

import pytest

from reflexarc_trainer.run.history import Row, best_of, has_reached

ROWS = [Row(100, 1.0, 0.5, 0.2, 40.0, 9.0), Row(200, 2.0, 0.1, 0.1, 20.0, 7.0)]


def rows(*scores: float) -> list[Row]:
    return [ROWS[0]._replace(validation_contacts_per_100m=score) for score in scores]


def test_best_point_is_the_first_of_equals() -> None:
    history = [row._replace(step=i) for i, row in enumerate(rows(3.0, 2.0, 2.0))]
    assert best_of(history) == history[1]
    assert best_of([]) is None


@pytest.mark.parametrize(
    ("scores", "goal", "reached"),
    [
        ((9.0, 5.0, 5.0), 5.0, True),
        ((5.0, 9.0, 5.0), 5.0, False),
        ((4.0, 4.0, 9.0), 5.0, False),
        ((4.0,), 5.0, False),
        ((4.0, math.nan), 5.0, False),
        ((4.0, 4.0), None, False),
    ],
)
def test_goal_is_reached_by_the_last_two_points(
    scores: tuple[float, ...], goal: float | None, reached: bool
) -> None:
    assert has_reached(rows(*scores), goal) is reached
