"""Results come from anybody: nothing that they name is imported or run."""

import hashlib
import json
import os
import sys
from dataclasses import replace
from importlib.resources import files
from pathlib import Path

import pytest

from reflexarc.wiring.entrants import sources_of_baselines
from reflexarc_pictures.suite_page import from_results
from reflexarc_pictures.suite_page.from_results import content_of
from reflexarc_sim_bridge.evaluation.protocol.entrant import Entrant
from reflexarc_sim_bridge.evaluation.protocol.results import Results
from reflexarc_sim_bridge.evaluation.protocol.suite import suite_named
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from support.page_results import page_results
from support.policies import exported

EVIL = """
from pathlib import Path
Path("it ran").touch()

class X:
    def __init__(self):
        Path("it ran").touch()
"""


@pytest.fixture(autouse=True)
def elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[Entrant]:
    """Of whom moments were drawn; no drive is made."""
    found: list[Entrant] = []

    def noted(entrant: Entrant, *_: object) -> list[object]:
        found.append(entrant)
        return []

    monkeypatch.setattr(from_results, "worst_moments", noted)
    return found


def results_of(source: str, content: str, suite: str = suite_named("lite").title) -> Results:
    made = page_results(["somebody"])
    agents = [replace(made.agents[0], source=source, hash=content)]
    return Results.from_json(
        json.loads(json.dumps(replace(made, agents=agents, suite=suite).to_json()))
    )


def page_of(results: Results, code: tuple[str, ...] | list[str] = ()) -> None:
    content_of(results, progress=lambda done, of: None, code=code)


@pytest.mark.parametrize("source", ["evil.py:X", "./evil.py:X", "evil:X", "package.evil:X"])
def test_code_that_results_name_is_not_run(source: str, drawn: list[Entrant]):
    Path("evil.py").write_text(EVIL)
    Path("package").mkdir()
    for name in ("__init__", "evil"):
        (Path("package") / f"{name}.py").write_text(EVIL)
    right = {hashlib.sha256(b"evil.py" + EVIL.encode()).hexdigest(), "", "ab" * 32}
    for content in right:
        page_of(results_of(source, content))
        page_of(results_of(source, content), sources_of_baselines())
    assert drawn == []
    assert not Path("it ran").exists()
    assert not {"evil", "package", "package.evil"} & set(sys.modules)


def test_a_process_is_not_ended_by_what_results_name(drawn: list[Entrant]):
    page_of(results_of("os:abort", ""), sources_of_baselines())
    assert drawn == []


def test_code_that_whoever_draws_names_is_run(drawn: list[Entrant]):
    source = "reflexarc_baselines.anchors.blind:Blind"
    own = Entrant("somebody", source).content_hash()
    page_of(results_of(source, own))
    assert drawn == []
    page_of(results_of(source, "ab" * 32), [source])  # not the same any more
    assert drawn == []
    page_of(results_of(source, own), sources_of_baselines())
    assert [each.source for each in drawn] == [source]


def test_policy_files_and_those_who_see_nothing_are_drawn(drawn: list[Entrant]):
    policy = exported(reference_contract(), seed=1)
    Path("mine.onnx").write_bytes(policy)
    page_of(results_of("mine.onnx", hashlib.sha256(policy).hexdigest()))
    page_of(results_of("blind", ""))
    assert [each.source for each in drawn] == ["mine.onnx", "blind"]


def test_a_name_with_a_colon_is_of_code_and_a_pipe_is_no_file(drawn: list[Entrant]):
    """Which it is must not hang on what lies there when it is looked for the second time."""
    policy = exported(reference_contract(), seed=1)
    Path("mine:onnx").write_bytes(policy)
    os.mkfifo("pipe")
    page_of(results_of("mine:onnx", hashlib.sha256(policy).hexdigest()))
    page_of(results_of("pipe", ""))  # whoever opened it would wait for ever
    assert drawn == []


@pytest.mark.parametrize("name", ["./mine.toml", "mine.toml"])
def test_no_file_of_a_suite_is_read_unless_whoever_draws_names_it(name: str, drawn: list[Entrant]):
    folder = files("reflexarc_sim_bridge").joinpath("evaluation/protocol/suites")
    shipped = folder.joinpath("lite.toml").read_text()
    Path("mine.toml").write_text(shipped.replace('name = "lite"', f'name = "{name}"'))
    results = results_of("blind", "", suite_named(name).title)
    assert content_of(results, progress=lambda done, of: None).suite is None
    assert content_of(results, name, lambda done, of: None).suite is not None
    assert len(drawn) == 1
