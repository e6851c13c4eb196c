from dataclasses import replace
from pathlib import Path

import pytest
from rich.console import RenderableType

from reflexarc.terminal.plain_console import PlainConsole
from reflexarc.terminal.policy_description import describe_policy
from reflexarc_runtime.contract.body_spec import BodySpec, Footprint
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.contract.state_spec import StateSpec
from reflexarc_runtime.policy.policy import LoadedPolicy, load_policy
from support.policies import exported

MUSEUM = Path(__file__).parents[2] / "golden" / "museum"
RICH = PolicyContract(
    actions=(
        Action("ahead", 1.0, 0.0),
        Action("[red]gently\x1b[31m", 0.5, 0.25, -0.125),
    ),
    safe_command=Action("creep", 0.1, 0.0),
    max_input_age_s=3600.0,
    recovery_inputs=5,
    hold_s=0.35,
    margin=0.1,
    body=BodySpec(Footprint(ahead_m=0.3, behind_m=0.2, half_width_m=0.25), 0.04, 2.5),
)


def lines(shown: RenderableType) -> list[str]:
    """What a terminal of 80 columns shows, each line without runs of spaces."""
    console = PlainConsole(width=80, color_system=None)
    with console.capture() as capture:
        console.print(shown)
    said = capture.get().splitlines()
    assert max(map(len, said)) <= 80
    return [" ".join(line.split()) for line in said]


def described(contract: PolicyContract) -> list[str]:
    policy = load_policy(exported(contract), verify=False, bounds=None)
    return lines(describe_policy(Path("policy.onnx"), policy))


@pytest.mark.parametrize(
    ("margin", "least_lead", "words"),
    [(0.0, 0.08, "0.08 in Q"), (0.1, 0.08, "0.1 of the Q-values' spread and 0.08 in Q")],
)
def test_a_least_lead_is_said(margin, least_lead, words):
    assert f"margin {words}" in described(replace(RICH, margin=margin, least_lead=least_lead))


def test_a_person_reads_every_speed_and_every_wait():
    said = described(RICH)
    for line in (
        "rate 50 Hz",
        "inputs at most 3600 s old; 5 good in a row before it drives",
        "hold 0.35 s, 18 ticks",
        "margin 0.1 of the Q-values' spread",
        "backends agree to 1e-06 × max(1, |Q|)",
        "body a rectangle: 0.3 m ahead, 0.2 m behind, 0.25 m to each side",
        "obeys after 0.04 s",
        "stops at 2.5 m/s²",
        "│ ahead │ 1 m/s │ 0 m/s │ 0 rad/s │",
        "│ creep (the safe command) │ 0.1 m/s │ 0 m/s │ 0 rad/s │",
    ):
        assert line in said


def test_names_from_a_file_are_shown_as_they_are_without_control_characters():
    assert r"│ [red]gently\x1b[31m │ 0.5 m/s │ 0.25 m/s │ -0.125 rad/s │" in described(RICH)


def test_what_the_usual_bounds_refuse_is_said_with_its_flag():
    said = " ".join(described(RICH))
    assert "beyond bounds inputs may be old" in said
    assert "--max-wait-s" in said
    assert "--allow-moving-stop" in said
    assert not [line for line in described(PolicyContract()) if "beyond" in line]


def test_the_simplest_policy_says_so():
    said = described(PolicyContract())
    for line in ("hold none", "margin none", "memory none", "body a point", "stops at once"):
        assert line in said


@pytest.mark.parametrize(
    ("contract", "line"),
    [
        (replace(RICH, body=BodySpec(Footprint(radius_m=0.2))), "body a circle of 0.2 m"),
        (replace(RICH, state=StateSpec(1)), "memory 1 value"),
        (replace(RICH, state=StateSpec(8)), "memory 8 values"),
    ],
)
def test_bodies_and_memories_are_named(contract: PolicyContract, line: str):
    loaded = load_policy(exported(RICH), verify=False, bounds=None)
    other = LoadedPolicy(contract, loaded.policy_hash, loaded.data, loaded.graph)
    assert line in lines(describe_policy(Path("policy.onnx"), other))


def test_a_digest_is_shown_in_short_or_its_absence_explained():
    policy = load_policy(exported(PolicyContract()))
    assert len(policy.digest) == 64
    assert f"digest {policy.digest[:12]}…" in lines(describe_policy(Path("p"), policy))
    older = load_policy(MUSEUM / "schema-2" / "rover.onnx")
    assert older.digest == ""
    assert "schema 2, which has no digest" in " ".join(lines(describe_policy(Path("p"), older)))
