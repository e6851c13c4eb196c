"""What a policy may ask for at most; and the body that it says it learned with."""

import math
from dataclasses import replace

import pytest

from reflexarc_runtime.contract.body_spec import BodySpec, Footprint
from reflexarc_runtime.contract.bounds import Bounds, check_bounds, excesses
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.motion import Action, sideways_actions
from reflexarc_runtime.contract.state_spec import StateSpec
from reflexarc_runtime.errors import ContractError
from reflexarc_runtime.policy.policy import load_policy
from support.policies import SMALL, exported

FAST = replace(SMALL, actions=(*sideways_actions(), Action("leap", 1e308, 0.0)))

CASES = {
    "--max-speed-mps": FAST,
    "--max-turn-radps": replace(SMALL, actions=(*sideways_actions(), Action("spin", 0, 0, -99.0))),
    "--max-wait-s": replace(SMALL, max_input_age_s=3600.0),
    "actions are held for": replace(SMALL, hold_s=60.0),
    "the body obeys after": replace(SMALL, body=BodySpec(actuation_delay_s=10.0)),
    "--allow-moving-stop": replace(SMALL, safe_command=Action("go", 0.5, 0.0)),
    "'go' drives": replace(SMALL, safe_command=Action("go", -50.0, 0.0)),
}


@pytest.mark.parametrize("words", CASES)
def test_a_policy_that_asks_for_too_much_is_refused_with_the_flag(words):
    with pytest.raises(ContractError) as caught:
        check_bounds(CASES[words], Bounds())
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("contract", CASES.values(), ids=CASES)
def test_wider_bounds_accept_it(contract):
    check_bounds(contract, Bounds(math.inf, math.inf, math.inf, allow_moving_stop=True))


def test_a_policy_is_checked_where_it_is_loaded_unless_nothing_will_move():
    data = exported(FAST)
    with pytest.raises(ContractError, match="policy: 'leap' drives: expected at most 20 m/s"):
        load_policy(data)
    assert load_policy(data, bounds=None).contract.actions == FAST.actions


@pytest.mark.parametrize(
    "sizes",
    [{"radius_m": -1.0}, {"radius_m": math.nan}, {"radius_m": 0.1, "ahead_m": 0.2}],
)
def test_an_impossible_footprint_is_refused(sizes):
    with pytest.raises(ContractError, match="footprint"):
        Footprint(**sizes)


@pytest.mark.parametrize(
    ("footprint", "reach_m"),
    [
        (Footprint(), 0.0),
        (Footprint(radius_m=0.2), 0.2),
        (Footprint(ahead_m=0.3, behind_m=0.1, half_width_m=0.4), 0.5),
    ],
)
def test_the_reach_is_the_farthest_point(footprint, reach_m):
    assert footprint.reach_m == pytest.approx(reach_m)


@pytest.mark.parametrize(
    "body", [{"deceleration_mps2": 0.0}, {"deceleration_mps2": math.inf}, {"actuation_delay_s": -1}]
)
def test_an_impossible_body_is_refused(body):
    with pytest.raises(ContractError, match=r"deceleration_mps2|actuation_delay_s"):
        BodySpec(**body)


@pytest.mark.parametrize(("size", "start"), [(2, (0.5,)), (1, (0.1,)), (1, (1e300,)), (-1, ())])
def test_an_impossible_memory_is_refused(size, start):
    with pytest.raises(ContractError, match="state"):
        StateSpec(size, start)


@pytest.mark.parametrize(
    "changes",
    [
        {"recovery_inputs": 0},
        {"hold_s": -1.0},
        {"margin": 1.1},
        {"least_lead": -0.1},
        {"least_lead": float("inf")},
        {"q_tolerance": 0.0},
    ],
)
def test_a_field_out_of_range_is_refused_by_its_name(changes):
    with pytest.raises(ContractError, match=next(iter(changes))):
        replace(PolicyContract(), **changes)


def test_everything_beyond_the_bounds_is_listed():
    much = replace(FAST, max_input_age_s=60.0, safe_command=Action("go", 0.5, 0.0))
    assert len(list(excesses(much, Bounds()))) == 3
    assert list(excesses(SMALL, Bounds())) == []


def test_a_bound_that_is_no_number_allows_nothing():
    with pytest.raises(ContractError, match="--max-speed-mps: expected a number"):
        check_bounds(SMALL, Bounds(max_speed_mps=math.nan))
