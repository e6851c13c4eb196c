"""The answer of a study in words, against sentences worked out by hand."""

import pytest

from reflexarc_sim_bridge.evaluation.scoring.statistics import Estimate
from reflexarc_trainer.study.answer import answer, overlap
from reflexarc_trainer.study.definition import Study, parse_study
from reflexarc_trainer.study.page import write_page
from reflexarc_trainer.study.summary import CellSummary, summarise
from support.small_study import results_of

HEAD = 'title = "T"\nquestion = "Is 0.9 good?"\nseeds = 4\n'
AXIS = '[[axis]]\nlabel = "λ (the paper: 0.9)"\nfield = "learner.trace_decay"\n'
VALUES = "values = [0.0, 0.5, 0.9, 1.0]\n"


def study_of(text: str) -> Study:
    return parse_study(text, "mine")


def cells(
    study: Study, *estimates: tuple[float, float, float] | None, blind: float | None = 36.0
) -> list[CellSummary]:
    """Summaries with the given estimates, as contacts per 100 m, or whatever the study measures."""
    return [
        CellSummary(
            cell=cell,
            figures=() if known is None else tuple(known),
            estimate=None if known is None else Estimate(*known),
            share_of_blind=None,
            contacts=None if known is None else known[0],
            blind=blind,
            diverged=0,
            missing=0,
            unit_s=1.0,
        )
        for cell, known in zip(study.cells, estimates, strict=True)
    ]


def test_the_best_is_named_with_what_is_not_told_apart_from_it_and_what_is_worse() -> None:
    study = study_of(HEAD + AXIS + VALUES)
    found = cells(study, (2.2, 2.1, 2.35), (2.0, 1.9, 2.1), (2.3, 2.25, 2.4), (3.0, 2.9, 3.1))
    assert answer(study, found) == (
        "λ 0.5 is best: 2.00 [1.90, 2.10] contacts per 100 m; worse: 0.9 (by 15 %), 1 (by 50 %); "
        "within the intervals of it: 0. An agent that never steers makes 36.0 contacts per 100 m; "
        "of that, “0.5” makes 6 %."
    )


def test_what_is_asked_about_is_what_the_others_are_compared_with() -> None:
    study = study_of(f'asked = "0.9"\n{HEAD}{AXIS}{VALUES}')
    found = cells(study, (2.2, 2.1, 2.3), (2.0, 1.9, 2.1), (4.0, 3.9, 4.1), (5.0, 4.0, 6.0))
    assert answer(study, found).startswith(
        "λ 0.9 comes to 4.00 [3.90, 4.10] contacts per 100 m; better: 0 (by 45 %), 0.5 (by 50 %); "
        "within the intervals of it: 1. "
    )


def test_groups_are_answered_for_one_by_one_and_cells_without_a_figure_are_named() -> None:
    learner = '[[axis]]\nlabel = "learner"\n[[axis.choice]]\nname = "a"\npreset = "paper"\n'
    study = study_of(f'{HEAD}{learner}[[axis.choice]]\nname = "b"\n{AXIS}values = [0.0, 0.9]\n')
    found = cells(study, (6.0, 5.9, 6.1), (7.0, 6.9, 7.1), (2.0, 1.9, 2.1), None)
    assert answer(study, found) == (
        "A: λ 0 is best: 6.00 [5.90, 6.10] contacts per 100 m; worse: 0.9 (by 17 %). "
        "B: λ 0 is best: 2.00 [1.90, 2.10] contacts per 100 m. Without a figure: “b, 0.9”. "
        "An agent that never steers makes 36.0 contacts per 100 m; of that, “b, 0” makes 6 %."
    )


def test_cells_are_compared_along_the_axis_that_the_question_asks_about() -> None:
    first = '[[axis]]\nlabel = "learner"\n[[axis.choice]]\nname = "a"\npreset = "paper"\n'
    study = study_of(
        f'asked = "a"\n{HEAD}{first}[[axis.choice]]\nname = "b"\n{AXIS}values = [0.5]\n'
    )
    assert answer(study, cells(study, (6.0, 5.9, 6.1), (3.0, 2.9, 3.1), blind=None)) == (
        "0.5: “a” comes to 6.00 [5.90, 6.10] contacts per 100 m; better: “b” (by 50 %)."
    )


def test_names_are_quoted_where_no_number_tells_cells_apart() -> None:
    text = f'asked = "a, b"\n{HEAD}[[cell]]\nname = "a, b"\n[[cell]]\nname = "c"\nsteps = 9\n'
    study = study_of(text)
    assert answer(study, cells(study, (2.0, 1.9, 2.1), (3.0, 2.9, 3.1), blind=None)) == (
        "“a, b” is best: 2.00 [1.90, 2.10] contacts per 100 m; worse: “c” (by 50 %)."
    )


def test_scores_are_the_better_the_higher_and_differ_in_their_own_unit() -> None:
    study = study_of(f'measure = "suite"\n{HEAD}{AXIS}values = [0.0, 0.5, 0.9]\n')
    found = cells(study, (0.6, 0.55, 0.65), (0.8, 0.75, 0.85), (-0.1, -0.2, 0.0))
    assert answer(study, found) == (
        "λ 0.5 is best: 0.800 [0.750, 0.850] score in the lite suite; "
        "worse: 0 (by 0.200), 0.9 (by 0.900). "
        "An agent that never steers scores 0, one that knows everything 1."
    )


def test_who_does_no_better_than_never_steering_is_named() -> None:
    study = study_of(HEAD + AXIS + "values = [0.0, 0.9]\n")
    found = cells(study, (2.0, 1.9, 2.1), (40.0, 39.0, 41.0))
    assert answer(study, found).endswith("No better than never steering: “0.9”.")


def test_an_edge_index_is_neither_good_nor_bad_and_is_not_set_against_contacts() -> None:
    study = study_of(f'measure = "edge_index"\n{HEAD}{AXIS}values = [0.0, 0.9]\n')
    found = cells(study, (1.0, 0.9, 1.1), (5.0, 4.9, 5.1))
    assert answer(study, found) == (
        "λ 0 is lowest: 1.00 [0.90, 1.10] edge index; higher: 0.9 (5.0 times)."
    )


@pytest.mark.parametrize(
    ("one", "other", "expected"),
    [
        ((2.0, 1.0, 3.0), (4.0, 3.0, 5.0), True),
        ((2.0, 1.0, 2.9), (4.0, 3.0, 5.0), False),
        ((2.0, 0.0, 9.0), (4.0, 3.0, 5.0), True),
    ],
)
def test_intervals_overlap_where_they_have_a_point_in_common(
    one: tuple[float, float, float], other: tuple[float, float, float], expected: bool
) -> None:
    assert overlap(Estimate(*one), Estimate(*other)) is expected
    assert overlap(Estimate(*other), Estimate(*one)) is expected


def test_the_answer_stands_on_the_page_below_the_question(study: Study) -> None:
    found = summarise(study, results_of(study))
    page = write_page(study, found, "study.png")
    question, said = page.split("\n\n")[1:3]
    assert question == "What if?"
    assert said == answer(study, found)
    assert answer(study, summarise(study, {})).startswith("Without a figure: “5, long”")


def test_blind_contacts_follow_from_the_share_where_a_result_does_not_tell_them(
    study: Study,
) -> None:
    """Figure 4 at a share of 0.4: 10 contacts of an agent that never steers, in all results."""
    assert [summary.blind for summary in summarise(study, results_of(study))] == [10.0] * 4
