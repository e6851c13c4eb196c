import dataclasses
import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec, Shading
from reflexarc_runtime.contract.golden import GoldenVectors
from reflexarc_runtime.contract.motion import Action, sideways_actions
from reflexarc_runtime.contract.provenance import Provenance
from reflexarc_runtime.contract.text import SCHEMA_VERSION, seal
from reflexarc_runtime.errors import ContractError

FULL = PolicyContract(
    retina=RetinaSpec(rays=2, fov_rad=1.0, frames=2, shading=Shading.COLOUR),
    max_input_age_s=0.25,
    provenance=Provenance("paper", 7, {"alpha": 0.5}, "ab", {"numpy": "2"}, "c0ffee", {"x": 1.5}),
    golden=GoldenVectors(((0, 1, 2, 255),), ((0.1, -0.25, 3.0),), (2,)),
)


NO_SEQUENCES: dict[str, list[object]] = {"sequences": []}


def edited(**changes: object) -> str:
    """The text of `FULL` with other fields, sealed anew, as whoever edits on purpose would."""
    document = json.loads(FULL.to_json())
    del document["digest"]
    return seal({**document, **changes})


def test_a_contract_survives_its_json():
    assert PolicyContract.from_json(FULL.to_json()) == FULL


@given(
    st.builds(
        RetinaSpec,
        rays=st.integers(1, 64),
        fov_rad=st.floats(0.01, 2 * math.pi),
        range_m=st.floats(0.01, 100.0),
        shading=st.sampled_from(Shading),
        frames=st.integers(1, 4),
        eyes=st.sampled_from([1, 2]),
        channels=st.sampled_from([1, 3]),
    ),
    st.floats(0.001, 10.0),
)
def test_any_retina_survives_its_json(retina: RetinaSpec, age_s: float):
    contract = PolicyContract(retina=retina, max_input_age_s=age_s)
    assert PolicyContract.from_json(contract.to_json()) == contract


def test_the_json_of_schema_1_loads_for_ever():
    """Written by hand from the schema, so that no later version can forget how to read it."""
    text = """{"schema": 1,
      "retina": {"rays": 2, "fov_rad": 1.5, "range_m": 5, "shading": "nearness", "frames": 1,
                 "eyes": 1, "baseline_m": 0, "channels": 1},
      "actions": [{"name": "stay", "linear_mps": 1, "lateral_mps": 0, "angular_radps": 0},
                  {"name": "left", "linear_mps": 1, "lateral_mps": 1, "angular_radps": 0}],
      "safe_command": {"name": "stop", "linear_mps": 0, "lateral_mps": 0, "angular_radps": 0},
      "rate_hz": 50, "max_input_age_s": 0.1,
      "provenance": {"preset": "p", "seed": 1, "config": {}, "config_hash": "", "versions": {},
                     "commit": "", "scores": {}},
      "golden": {"retinas": [[0, 255]], "q_values": [[0.5, 1]], "actions": [1]}}"""
    contract = PolicyContract.from_json(text)
    assert contract.actions[1] == Action("left", 1.0, 1.0, 0.0)
    assert contract.retina.shape == (1, 2, 1)
    assert contract.golden.q_values == ((0.5, 1.0),)


def test_the_paper_s_actions_stay_first_so_that_a_tie_stays():
    assert [action.name for action in sideways_actions()] == ["stay", "left", "right"]
    assert sideways_actions(2.0, 0.5)[1].lateral_mps == 0.5  # left is positive


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "expected JSON"),
        ("[" * 100_000, "expected JSON"),
        ("[]", "expected a JSON object"),
        ("{}", "schema version"),
        (edited(schema=SCHEMA_VERSION + 1), "newer than this reflexarc"),
        (edited(schema="1"), "schema version"),
        (edited(schema=True), "schema version"),
        (edited(extra=1), "contract.extra: unknown; known: retina, actions, "),
        (edited(rate_hz="fast"), "contract.rate_hz: expected a number, got 'fast'"),
        (edited(rate_hz=True), "contract.rate_hz: expected a number, got True"),
        (edited(rate_hz=0), "rate_hz"),
        (edited(rate_hz=math.nan), "rate_hz"),
        (edited(retina=[]), "contract.retina: expected an object"),
        (edited(retina={"rays": 2}), "contract.retina.fov_rad: missing; expected a number"),
        (edited(actions=[{"name": "stay"}]), "contract.actions[0].linear_mps: missing"),
        (
            edited(golden={"retinas": [[0]], "q_values": [], "actions": [], **NO_SEQUENCES}),
            "golden",
        ),
        (
            edited(
                golden={"retinas": [0] * 4, "q_values": [[0.0] * 3], "actions": [0], **NO_SEQUENCES}
            ),
            "contract.golden.retinas[0]: expected a list of whole numbers, got 0",
        ),
        (
            edited(
                golden={"retinas": [[0] * 4], "q_values": [0.0] * 3, "actions": [0], **NO_SEQUENCES}
            ),
            "contract.golden.q_values[0]: expected a list of numbers, got 0.0",
        ),
        (
            edited(golden={"retinas": 0, "q_values": [], "actions": [], **NO_SEQUENCES}),
            "contract.golden.retinas: expected a list of lists, got 0",
        ),
        (
            edited(
                golden={"retinas": [[0] * 4], "q_values": [[0, 0]], "actions": [0], **NO_SEQUENCES}
            ),
            "golden.q_values",
        ),
    ],
)
def test_a_bad_contract_is_refused_in_one_line(text: str, words: str):
    with pytest.raises(ContractError) as caught:
        PolicyContract.from_json(text)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "changes",
    [
        {"rays": 0},
        {"fov_rad": 7.0},
        {"range_m": -1.0},
        {"range_m": math.inf},
        {"eyes": 3},
        {"channels": 2},
        {"frames": 0},
        {"rays": 4096, "frames": 1, "eyes": 2, "channels": 3, "baseline_m": math.nan},
    ],
)
def test_an_impossible_eye_is_refused(changes: dict[str, float]):
    with pytest.raises(ContractError):
        RetinaSpec(**changes)


def test_actions_need_names_of_their_own_and_finite_speeds():
    with pytest.raises(ContractError, match="distinct"):
        PolicyContract(actions=(Action("a", 1.0, 0.0), Action("a", 1.0, 1.0)))
    with pytest.raises(ContractError, match="finite"):
        Action("fast", math.inf, 0.0)


def test_a_contract_cannot_be_changed():
    with pytest.raises(dataclasses.FrozenInstanceError):
        FULL.rate_hz = 1.0  # type: ignore[misc]
