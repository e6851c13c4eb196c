from dataclasses import replace

import pytest

from reflexarc_runtime.contract.body_spec import BodySpec
from reflexarc_runtime.contract.bounds import Bounds, check_bounds, excesses
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.errors import ContractError

USUAL = PolicyContract()
BEYOND: dict[str, tuple[PolicyContract, Bounds]] = {
    "--max-speed-mps": (
        replace(USUAL, actions=(Action("back", -30.0, 0.0), Action("left", 0.0, 30.0))),
        Bounds(max_speed_mps=30.0),
    ),
    "--max-turn-radps": (
        replace(USUAL, actions=(Action("go", 1.0, 0.0), Action("spin", 0.0, 0.0, -30.0))),
        Bounds(max_turn_radps=30.0),
    ),
    "--max-wait-s": (
        replace(USUAL, max_input_age_s=3.0, hold_s=3.0, body=BodySpec(actuation_delay_s=3.0)),
        Bounds(max_wait_s=3.0),
    ),
    "--allow-moving-stop": (
        replace(USUAL, safe_command=Action("creep", 0.0, 0.0, 0.1)),
        Bounds(allow_moving_stop=True),
    ),
}
"""A contract beyond the usual bounds by the flag that it needs, and the bounds with that flag."""


@pytest.mark.parametrize("flag", BEYOND)
def test_what_is_beyond_the_bounds_is_refused_with_the_flag_that_allows_it(flag: str):
    contract, wider = BEYOND[flag]
    with pytest.raises(ContractError, match=flag):
        check_bounds(contract, Bounds())
    check_bounds(contract, wider)


def test_everything_beyond_the_bounds_is_listed():
    assert [len(list(excesses(contract, Bounds()))) for contract, _ in BEYOND.values()] == [
        2,
        1,
        3,
        1,
    ]
    assert list(excesses(USUAL, Bounds())) == []


def test_a_bound_that_is_no_number_allows_nothing():
    with pytest.raises(ContractError):
        check_bounds(USUAL, Bounds(max_speed_mps=float("nan")))
