"""The line of an agent that never steers, read back from the figure."""

import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from reflexarc_trainer.study.blind_line import blind_values, draw_blind_line, draw_blind_marks
from reflexarc_trainer.study.definition import Study, parse_study
from reflexarc_trainer.study.summary import summarise
from support.small_study import STUDY_TEXT, results_of


def drawn(axes: Axes) -> list[tuple[list[float], list[float]]]:
    """Lines: their x and their y."""
    return [
        (list(map(float, line.get_xdata())), list(map(float, line.get_ydata())))  # type: ignore[arg-type]  # lists, as given
        for line in axes.lines
    ]


@pytest.fixture
def axes() -> Axes:
    return Figure().add_subplot()


def test_one_value_is_one_line_and_several_are_one_each(axes: Axes) -> None:
    draw_blind_line(axes, {"a": [(0.0, 9.0), (1.0, 9.0)], "b": [(0.0, 9.0), (1.0, 9.0)]}, 8.0)
    assert drawn(axes) == [([0.0, 1.0], [9.0, 9.0])]
    draw_blind_line(axes, {"a": [(0.0, 9.0), (1.0, None)], "b": [(0.0, 5.0)]}, 8.0)
    assert drawn(axes)[1:] == [([0.0], [9.0]), ([0.0], [5.0])]


def test_what_lies_far_off_is_told_in_words(axes: Axes) -> None:
    draw_blind_line(axes, {"a": [(0.0, 36.0), (1.0, 35.0)]}, 3.0)
    draw_blind_marks(axes, [36.0, None, 5.0], 3.0)
    said = [text.get_text() for text in axes.texts]
    assert said == ["↑ never steering: 35.0 to 36.0", "→ 36.0 never steering"]
    draw_blind_marks(axes, [36.0, 36.0], 3.0)
    assert axes.texts[-1].get_text() == "→ never steering: 36.0"
    assert len(axes.texts) == 3
    ((x, y),) = drawn(axes)
    assert x == [5.0, 5.0]
    assert sum(y) / 2 == 2.0


def test_each_measure_has_its_own_mark(study: Study) -> None:
    def values(measure: str) -> set[float | None]:
        own = parse_study(f'measure = "{measure}"\n{STUDY_TEXT}', "mine")
        return set(blind_values(own, summarise(own, results_of(own))))

    assert values("contacts") == {10.0}
    assert values("share_of_blind") == {1.0}
    assert values("suite") == {0.0}
    assert values("edge_index") == {None}
