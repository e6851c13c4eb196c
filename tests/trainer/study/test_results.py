"""Results on the disk, and the page that is made of them."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

from reflexarc_runtime.errors import UsageError
from reflexarc_trainer.study.definition import Study, parse_study
from reflexarc_trainer.study.figure import draw_study
from reflexarc_trainer.study.page import write_page
from reflexarc_trainer.study.results import ResultsFile, matching, read_results
from reflexarc_trainer.study.study import plan, run_study
from reflexarc_trainer.study.summary import missed_targets, summarise
from reflexarc_trainer.study.targets import Target
from reflexarc_trainer.study.unit import Result, code_key

TEXT = """\
title = "Nothing in particular"
question = "What if?"
preset = "online"
seeds = 4

[[axis]]
label = "hidden units"
field = "network.hidden"
values = [5, 20]

[[axis]]
label = "eye"

[[axis.choice]]
name = "long"

[[axis.choice]]
name = "short"
"retina.range_m" = 1.0
"""


@pytest.fixture
def study() -> Study:
    return parse_study(TEXT, "mine")


def results(study: Study) -> dict[str, Result]:
    """Figures 0 to 15 by seed and cell; the last one has diverged, the first of all is missing."""
    found = {}
    for n, unit in enumerate(study.units()):
        figure = None if n == 15 else float(n)
        share = None if figure is None else figure / 10.0
        found[unit.hash] = Result(unit.hash, code_key(), figure is None, 9, 1.0, 1.0, figure, share)
    del found[study.units()[0].hash]
    return found


def inked(picture: Path) -> int:
    return int(np.count_nonzero(imread(picture)[..., :3].min(axis=2) < 0.9))


def test_what_is_appended_is_read_again(study: Study, tmp_path: Path) -> None:
    path = tmp_path / "deep" / "results.jsonl"
    assert read_results(path) == []
    with ResultsFile(path) as file:
        for result in results(study).values():
            file.append(result)
    assert read_results(path) == list(results(study).values())


def test_torn_line_is_not_read_and_the_next_result_stands_on_its_own(
    study: Study, tmp_path: Path
) -> None:
    path, (first, second, *_) = tmp_path / "results.jsonl", results(study).values()
    with ResultsFile(path) as file:
        file.append(first)
    whole = path.read_bytes()
    path.write_bytes(whole + whole[: len(whole) // 2])
    assert read_results(path) == [first]
    with ResultsFile(path) as file:
        file.append(second)
    assert read_results(path) == [first, second]


def test_lines_of_another_version_are_left_alone(study: Study, tmp_path: Path) -> None:
    path, first = tmp_path / "results.jsonl", next(iter(results(study).values()))
    path.write_bytes(b'{"unit": "a", "speed": 3}\nnot JSON\n\xff\xfe\n[1]\n')
    with ResultsFile(path) as file:
        file.append(first)
    assert read_results(path) == [first]
    assert path.read_bytes().startswith(b'{"unit": "a"')


def test_two_studies_do_not_write_into_one_folder(tmp_path: Path) -> None:
    with (
        ResultsFile(tmp_path / "results.jsonl"),
        pytest.raises(UsageError, match="another study is running here"),
    ):
        ResultsFile(tmp_path / "results.jsonl")


def test_results_of_other_code_or_no_longer_asked_for_are_not_used(
    study: Study, tmp_path: Path
) -> None:
    there = list(results(study).values())
    foreign = dataclasses.replace(there[0], unit="0" * 64)
    older = dataclasses.replace(there[1], code="older")
    with ResultsFile(tmp_path / "results.jsonl") as file:
        for result in (foreign, older, *there[2:5]):
            file.append(result)
    todo = plan(study, tmp_path)
    assert set(todo.there) == {result.unit for result in there[2:5]}
    assert (len(todo.units), len(todo.pending), todo.unused) == (16, 13, 1)
    any_code = plan(study, tmp_path, any_code=True)
    assert set(any_code.there) == {result.unit for result in there[1:5]}
    assert any_code.estimate_s(2) == pytest.approx(any_code.estimate_s(1) / 2)
    assert matching([foreign], todo.units, "") == {}


def test_summary_is_over_the_seeds_that_have_a_figure(study: Study) -> None:
    first, _, _, last = summarise(study, results(study))
    assert (first.figures, first.missing, first.diverged) == ((4.0, 8.0, 12.0), 1, 0)
    assert (last.figures, last.missing, last.diverged) == ((3.0, 7.0, 11.0), 0, 1)
    assert first.estimate is not None
    assert first.estimate.value == 8.0
    assert first.share_of_blind == pytest.approx(0.8)


def test_page_has_a_row_a_cell_and_says_where_it_comes_from(study: Study) -> None:
    page = write_page(study, summarise(study, results(study)), "study.png")
    assert "| 5 | long | 3, 1 missing | 8.00 [4.00, 12.00] | 4.00 | 12.00 | 0.800 |" in page
    assert "| 20 | short | 3, 1 diverged | 7.00 [3.00, 11.00] |" in page
    assert "| runs | 15 of 16 |" in page
    assert TEXT.strip() in page
    assert "![Nothing in particular](study.png)" in page


def test_study_without_any_result_has_a_page_and_a_picture(study: Study) -> None:
    nothing = summarise(study, {})
    assert "0, 4 missing" in write_page(study, nothing, "study.png")
    assert draw_study(study, nothing).startswith(b"\x89PNG")


@pytest.mark.parametrize("kind", ["lines", "rows"])
def test_picture_shows_every_cell(kind: str, tmp_path: Path) -> None:
    text = TEXT if kind == "lines" else TEXT.replace("[5, 20]", "[[5], [20]]")
    study = parse_study(text, "mine")
    assert study.axes[0].is_numeric == (kind == "lines")
    summaries = summarise(study, results(study))
    (tmp_path / "a.png").write_bytes(draw_study(study, summaries))
    (tmp_path / "b.png").write_bytes(draw_study(study, [summaries[0]]))
    whole, part = (inked(tmp_path / name) for name in ("a.png", "b.png"))
    assert whole > part


@pytest.mark.parametrize(
    ("target", "figures", "said"),
    [
        (Target("a", each_at_most=3.0), [1.0, 2.0, 3.0], []),
        (Target("a", each_at_most=2.5), [1.0, 2.0, 3.0], ["a seed has 3, expected ≤ 2.5"]),
        (Target("a", mean_at_most=1.5), [1.0, 2.0, 3.0], ["mean 2, expected ≤ 1.5"]),
        (Target("a", mean_at_least=2.0, each_at_least=1.5), [1.0, 2.0, 3.0], ["a seed has 1, "]),
        (Target("a", mean_at_most=9.0), [1.0, 2.0], ["1 of 3 seeds have no figure"]),
    ],
)
def test_targets_bound_the_mean_and_every_seed(
    target: Target, figures: list[float], said: list[str]
) -> None:
    missed = target.missed(figures, 3)
    assert len(missed) == len(said)
    assert all(words in got for words, got in zip(said, missed, strict=True))


def test_missed_targets_are_on_the_page(study: Study) -> None:
    text = f'{TEXT}[[target]]\ncell = "5, short"\nmean_at_most = 1.0\n'
    study = parse_study(text, "mine")
    summaries = summarise(study, results(study))
    assert missed_targets(study, summaries) == ["5, short: mean 7, expected ≤ 1"]
    page = write_page(study, summaries, "study.png")
    assert "Missed: 5, short: mean 7, expected ≤ 1." in page


def test_whole_study_starts_no_process_again(study: Study, tmp_path: Path) -> None:
    everything = dict(results(study))
    first = study.units()[0].hash
    everything[first] = dataclasses.replace(next(iter(everything.values())), unit=first)
    with ResultsFile(tmp_path / "results.jsonl") as file:
        for result in everything.values():
            file.append(result)
    before = (tmp_path / "results.jsonl").read_bytes()
    done = run_study(study, tmp_path, jobs=2)
    assert (done.done, done.units, done.before, done.interrupted) == (16, 16, 16, False)
    assert (tmp_path / "results.jsonl").read_bytes() == before
    assert done.page.exists()
