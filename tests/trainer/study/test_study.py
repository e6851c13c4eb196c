"""A study from its file to its page."""

import dataclasses
from pathlib import Path

import pytest

from reflexarc_trainer.study.definition import Study
from reflexarc_trainer.study.results import ResultsFile, matching
from reflexarc_trainer.study.study import plan, run_study
from support.small_study import results_of


def test_results_of_other_code_or_no_longer_asked_for_are_not_used(
    study: Study, tmp_path: Path
) -> None:
    there = list(results_of(study).values())
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


def test_whole_study_starts_no_process_again(study: Study, tmp_path: Path) -> None:
    everything = dict(results_of(study))
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
