"""The page of a study."""

from reflexarc_trainer.study.definition import Study, parse_study
from reflexarc_trainer.study.page import write_page
from reflexarc_trainer.study.summary import missed_targets, summarise
from support.small_study import STUDY_TEXT, results_of


def test_page_has_a_row_a_cell_and_says_where_it_comes_from(study: Study) -> None:
    page = write_page(study, summarise(study, results_of(study)), "study.png")
    assert "| 5 | long | 3, 1 missing | 8.00 [4.00, 12.00] | 4.00 | 12.00 | 0.800 |" in page
    assert "| 20 | short | 3, 1 diverged | 7.00 [3.00, 11.00] |" in page
    assert "| runs | 15 of 16 |" in page
    assert STUDY_TEXT.strip() in page
    assert "![Nothing in particular](study.png)" in page


def test_missed_targets_are_on_the_page(study: Study) -> None:
    text = f'{STUDY_TEXT}[[target]]\ncell = "5, short"\nmean_at_most = 1.0\n'
    study = parse_study(text, "mine")
    summaries = summarise(study, results_of(study))
    assert missed_targets(study, summaries) == ["5, short: mean 7, expected ≤ 1"]
    page = write_page(study, summaries, "study.png")
    assert "Missed: 5, short: mean 7, expected ≤ 1." in page
