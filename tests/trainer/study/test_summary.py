"""What the seeds of a cell say together."""

import pytest

from reflexarc_trainer.study.definition import Study
from reflexarc_trainer.study.summary import summarise
from support.small_study import results_of


def test_summary_is_over_the_seeds_that_have_a_figure(study: Study) -> None:
    first, _, _, last = summarise(study, results_of(study))
    assert (first.figures, first.missing, first.diverged) == ((4.0, 8.0, 12.0), 1, 0)
    assert (last.figures, last.missing, last.diverged) == ((3.0, 7.0, 11.0), 0, 1)
    assert first.estimate is not None
    assert first.estimate.value == 8.0
    assert first.share_of_blind == pytest.approx(0.8)
