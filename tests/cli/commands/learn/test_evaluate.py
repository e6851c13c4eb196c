"""`reflexarc evaluate`: what its flags say and show; killed runs are in `end_to_end`."""

import json
from pathlib import Path

import pytest

from reflexarc.main import main
from reflexarc.terminal.score_tables import short_names
from support.small_suite import write_small_suite


def test_field_measures_controllers_beside_blind_at_another_rate_in_another_world(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    _, controllers = write_small_suite(tmp_path)
    mine = f"{controllers}:Mine"
    words = ["evaluate", "--controller", mine, "--agents", "64", "--steps", "200", "--json"]
    assert main(words) == 0
    usual = json.loads(capsys.readouterr().out)
    assert list(usual) == ["blind", mine]
    assert usual[mine]["share_of_blind"] < 0.9
    assert main([*words, "--rate", "50", "--world", "corridor-10"]) == 0
    other = json.loads(capsys.readouterr().out)
    # A step that ends in a contact is shorter.
    assert usual["blind"]["distance_m"] == pytest.approx(64 * 200 * 0.1, rel=0.03)
    assert other["blind"]["distance_m"] == pytest.approx(64 * 200 * 0.02, rel=0.03)


def test_field_follows_a_body_that_turns_to_its_first_contact(
    capsys: pytest.CaptureFixture[str],
) -> None:
    rover = str(Path(__file__).parents[3] / "golden" / "museum" / "schema-2" / "rover.onnx")
    assert main(["evaluate", rover, "--agents", "32", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert list(found) == [f"blind, as {rover}", rover]
    # A Poisson forest: the mean free path is 1 / 2ρR = 2.78 m, whatever the heading.
    assert found[f"blind, as {rover}"]["farthest_m"] == pytest.approx(2.78, rel=0.4)
    assert found[rover]["farthest_m"] > 4.0


def test_suite_prints_tables_and_writes_results(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    suite, controllers = write_small_suite(tmp_path)
    out = tmp_path / "out"
    words = ["evaluate", "--controller", f"{controllers}:Mine", "--baseline", "braitenberg-2b"]
    words += ["blind", "--suite", str(suite), "--jobs", "1", "-o", str(out)]
    assert main(words) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "small-1, robot: score by family" in said
    assert "small-1, field: headline" in said
    assert sorted(path.name for path in out.iterdir()) == [
        "index.html",
        "results.json",
        "rows.jsonl",
        "times.json",
    ]
    document = json.loads((out / "results.json").read_text())
    cards = {(card["name"], card["setting"]): card for card in document["scores"]}
    assert len(cards) == 6
    assert cards["blind", "robot"]["headline"]["value"] == 0.0
    assert cards["braitenberg-2b", "field"]["headline"]["value"] < 0.0  # it seeks what it sees
    assert [agent["tuned"][:8] for agent in document["agents"]] == ["", "adapted:", ""]
    before = (out / "results.json").read_bytes()
    assert main([*words, "--resume", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == document
    assert (out / "results.json").read_bytes() == before


@pytest.mark.long
def test_against_has_a_status_for_each_answer(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    suite, _ = write_small_suite(tmp_path)
    few = ["--suite", str(suite), "--jobs", "1", "--json"]
    assert main(["evaluate", "--baseline", "blind", "--against", "blind", *few]) == 0
    same = json.loads(capsys.readouterr().out)
    assert same["verdict"] == "keeps"
    assert {family["loss"] for family in same["families"]} == {0.0}
    assert main(["evaluate", "--baseline", "blind", "--against", "braitenberg-2a", *few]) == 1
    assert json.loads(capsys.readouterr().out)["verdict"] == "loses"
    # Blind makes 1.30 times less than random: of a margin of 0.315 neither side can be shown.
    close = ["--baseline", "random", "--against", "blind", "--loss", "0.315"]
    assert main(["evaluate", *close, *few[:-1]]) in (0, 1, 3)
    assert "margin 32%" in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--baseline", "blind", "random", "--against", "blind"], "one policy to judge, got 2"),
        (["--baseline", "blind", "--against", "blind", "--loss", "0"], "--loss: expected a share"),
        (["--baseline", "blind", "--against", "zebra"], "zebra"),
        (["--baseline", "blind", "--loss", "0.2"], "--loss: expected only with --against"),
        ([], "expected a policy, --controller or --baseline, got none"),
        (["--controller", "mine"], "expected module:Class or file.py:Class, got 'mine'"),
        (["--controller", "no_such_module_:Mine"], "ModuleNotFoundError"),
        (["--baseline", "zebra"], "baseline: none is named 'zebra'; known: braitenberg-2a"),
        (["none.onnx"], "none.onnx"),
        (["--baseline", "blind", "--family", "discs"], "--family: expected only with --suite"),
        (["--baseline", "blind", "--jobs", "2"], "--jobs: expected only with --suite"),
        (["--baseline", "blind", "--resume"], "--resume: expected only with --suite"),
        (["--baseline", "blind", "--suite", "lite", "--world", "dim"], "only without --suite"),
        (["--baseline", "blind", "--suite", "lite", "--agents", "9"], "only without --suite"),
        (["--baseline", "blind", "--suite", "zebra"], "suite: expected one of edge, full, lite"),
        (["--baseline", "blind", "--suite", "lite", "--family", "x"], "family: expected one of"),
        (["--baseline", "blind", "--rate", "-3"], "--rate: expected 0.1 to 10000"),
        (
            ["--baseline", "random", "random", "--suite", "lite"],
            "expected distinct names, got twice: random",
        ),
        (
            ["--baseline", "blind", "--suite", "lite", "--setting", "field", "--rate", "9"],
            "the field's is 10 Hz",
        ),
    ],
)
def test_what_cannot_be_is_one_line(
    words: list[str], said: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert main(["evaluate", *words]) == 2
    complaint = capsys.readouterr().err
    assert complaint.count("\n") == 1
    assert said in complaint


@pytest.mark.parametrize("raised", ["ValueError('no')", "SystemExit(5)"])
def test_what_a_controller_raises_on_the_field_is_one_line(
    raised: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    source = """
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
class Broken:
    contract = reference_contract()
    def decide(self, retinas):
        raise """
    (tmp_path / "broken.py").write_text(source + raised)
    broken = f"{tmp_path / 'broken.py'}:Broken"
    assert main(["evaluate", "--controller", broken, "--agents", "4", "--steps", "4"]) == 2
    assert f"broken.py:Broken raised {raised[:10]}" in capsys.readouterr().err


def test_paths_are_shown_by_what_tells_them_apart() -> None:
    names = ["runs/a-0/policy.onnx", "runs/a-1/policy.onnx", "other.onnx", "blind"]
    assert list(short_names(names).values()) == [
        "a-0/policy.onnx",
        "a-1/policy.onnx",
        "other.onnx",
        "blind",
    ]
