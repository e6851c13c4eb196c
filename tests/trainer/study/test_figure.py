"""The picture of a study."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from reflexarc_trainer.study.definition import Study, parse_study
from reflexarc_trainer.study.figure import draw_study
from reflexarc_trainer.study.page import write_page
from reflexarc_trainer.study.summary import summarise
from support.small_study import STUDY_TEXT, results_of


def inked(picture: Path) -> int:
    return int(np.count_nonzero(imread(picture)[..., :3].min(axis=2) < 0.9))


def test_study_without_any_result_has_a_page_and_a_picture(study: Study) -> None:
    nothing = summarise(study, {})
    assert "0, 4 missing" in write_page(study, nothing, "study.png")
    assert draw_study(study, nothing).startswith(b"\x89PNG")


@pytest.mark.parametrize("kind", ["lines", "rows"])
def test_picture_shows_every_cell(kind: str, tmp_path: Path) -> None:
    text = STUDY_TEXT if kind == "lines" else STUDY_TEXT.replace("[5, 20]", "[[5], [20]]")
    study = parse_study(text, "mine")
    assert study.axes[0].is_numeric == (kind == "lines")
    summaries = summarise(study, results_of(study))
    (tmp_path / "a.png").write_bytes(draw_study(study, summaries))
    (tmp_path / "b.png").write_bytes(draw_study(study, [summaries[0]]))
    whole, part = (inked(tmp_path / name) for name in ("a.png", "b.png"))
    assert whole > part
