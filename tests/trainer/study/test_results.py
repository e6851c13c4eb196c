"""Results on the disk."""

from pathlib import Path

import pytest

from reflexarc_runtime.errors import UsageError
from reflexarc_trainer.study.definition import Study
from reflexarc_trainer.study.results import ResultsFile, read_results
from support.small_study import results_of


def test_what_is_appended_is_read_again(study: Study, tmp_path: Path) -> None:
    path = tmp_path / "deep" / "results.jsonl"
    assert read_results(path) == []
    with ResultsFile(path) as file:
        for result in results_of(study).values():
            file.append(result)
    assert read_results(path) == list(results_of(study).values())


def test_torn_line_is_not_read_and_the_next_result_stands_on_its_own(
    study: Study, tmp_path: Path
) -> None:
    path, (first, second, *_) = tmp_path / "results.jsonl", results_of(study).values()
    with ResultsFile(path) as file:
        file.append(first)
    whole = path.read_bytes()
    path.write_bytes(whole + whole[: len(whole) // 2])
    assert read_results(path) == [first]
    with ResultsFile(path) as file:
        file.append(second)
    assert read_results(path) == [first, second]


def test_lines_of_another_version_are_left_alone(study: Study, tmp_path: Path) -> None:
    path, first = tmp_path / "results.jsonl", next(iter(results_of(study).values()))
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
