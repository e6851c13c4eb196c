import json
from pathlib import Path
from types import SimpleNamespace

import pytest

from reflexarc.main import main
from reflexarc_baselines import genome_files
from reflexarc_baselines.evolving import evolution
from reflexarc_baselines.registry import HOMES, PYTHON_ONLY
from reflexarc_runtime.policy.policy import load_policy


def said(words: list[str], capsys: pytest.CaptureFixture[str]) -> str:
    assert main(["baselines", *words]) == 0
    return capsys.readouterr().out


def test_every_baseline_is_listed_with_its_source(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setenv("COLUMNS", "200")
    assert all(name in said([], capsys) for name in ("rob-nav", "vfh-plus"))
    rows = json.loads(said(["list", "--json"], capsys))["baselines"]
    assert [row["name"] for row in rows] == list(HOMES)
    assert all(row["source"] and row["fidelity"] and row["home_world"] for row in rows)
    assert {row["name"] for row in rows if not row["exports"]} == set(PYTHON_ONLY)
    of = {row["name"]: row for row in rows}
    assert of["three-motions"]["parameters"] == {"rays": 2, "preference_m": 0.0224}
    assert (of["three-motions"]["memory"], of["rob-nav"]["memory"]) == (0, 4)
    assert (of["braitenberg-2a"]["sees"], of["vfh-plus"]["sees"]) == ("retina", "ranges")


def test_a_search_is_a_table_and_an_object(capsys: pytest.CaptureFixture[str]):
    words = ["search", "three-motions", "--trials", "2", "--seed", "3"]
    assert "shipped" in said(words, capsys)
    report = json.loads(said([*words, "--json"], capsys))
    assert (report["name"], report["seed"], len(report["trials"])) == ("three-motions", 3, 2)
    assert report["budget"] == {"trials": 2, "agents": 256, "steps": 200}


def test_an_exported_baseline_is_a_policy_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    path = tmp_path / "p.onnx"
    words = ["export", "subsumption", "--rate", "20", "-o", str(path), "--json"]
    told = json.loads(said(words, capsys))
    policy = load_policy(path)
    assert told["policy_hash"] == policy.policy_hash
    assert told["rate_hz"] == policy.contract.rate_hz == 20.0


def test_evolving_writes_the_genome_of_the_name_and_seed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    """The evolving itself has its own tests; here it is another that says what it was asked."""

    def asked(name: str, seed: int, progress: object) -> object:
        return SimpleNamespace(genome=f"{name}-{seed}", provenance=SimpleNamespace(validation=1.5))

    monkeypatch.setattr(evolution, "evolve", asked)
    monkeypatch.setattr(genome_files, "genome_text", lambda genome, _: genome)
    path = tmp_path / "g.toml"
    words = ["evolve", "closed-loop", "--seed", "4", "-o", str(path), "--json"]
    assert json.loads(said(words, capsys)) == {"genome": str(path), "validation": 1.5}
    assert path.read_text() == "closed-loop-4"


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["list", "rob-nav"], "list: expected no name, got rob-nav"),
        (["search"], "search: expected the name of a baseline, got none"),
        (["search", "nobody"], "none is named 'nobody'"),
        (["search", "rob-nav", "-o", "x"], "search: expected no file to write, got x"),
        (["export", "rob-nav"], "export: expected -o FILE, got none"),
        (["export", "stereo", "-o", "x.onnx"], "stereo cannot be a policy file: it matches edges"),
        (["search", "rob-nav", "--rate", "9"], "--rate: only export has one, not search"),
        (["export", "rob-nav", "--rate", "0", "-o", "x.onnx"], "rate_hz: expected 0.1 to 10000"),
        (["export", "rob-nav", "--rate", "nan", "-o", "x.onnx"], "rate_hz: expected 0.1 to 10000"),
        (["evolve", "rob-nav", "-o", "x.toml"], "evolving: none is named 'rob-nav'"),
        (["search", "rob-nav", "--trials", "0"], "expected trials ≥ 1, got 0"),
    ],
)
def test_wrong_use_is_one_line(
    words: list[str], complaint: str, capsys: pytest.CaptureFixture[str]
):
    assert main(["baselines", *words]) == 2
    assert complaint in capsys.readouterr().err
