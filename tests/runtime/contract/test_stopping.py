import dataclasses
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_runtime.contract.body_spec import BodySpec, Footprint
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.contract.stopping import (
    check_speed,
    delays_s,
    largest_speed_mps,
    stopping_way_m,
    why_too_fast,
)
from reflexarc_runtime.errors import ContractError

BODY = BodySpec(Footprint(radius_m=0.5), actuation_delay_s=0.2, deceleration_mps2=2.0)


def contract(speed_mps: float, body: BodySpec = BODY, lateral_mps: float = 0.0) -> PolicyContract:
    """0.3 s old, 0.1 s between two decisions, valid for 0.3 s; it sees 5 m."""
    return PolicyContract(
        retina=RetinaSpec(range_m=5.0),
        actions=(Action("go", speed_mps, 0.0), Action("aside", speed_mps, lateral_mps)),
        rate_hz=10.0,
        max_input_age_s=0.3,
        body=body,
    )


def test_all_delays_add_up() -> None:
    assert delays_s(contract(1.0)) == pytest.approx(0.3 + 0.1 + 0.3 + 0.2)


def test_the_largest_speed_by_hand() -> None:
    """v · 0.9 + v² / 4 = 4.5, so v = −1.8 + √(1.8² + 18) = 2.8087…"""
    fastest = largest_speed_mps(4.5, 0.9, 2.0)
    assert fastest == pytest.approx(-1.8 + math.sqrt(3.24 + 18.0))
    assert stopping_way_m(2.0, 0.9, 2.0) == pytest.approx(1.8 + 1.0)
    assert not why_too_fast(contract(2.808))
    assert "expected at most 2.81 m/s" in why_too_fast(contract(2.809))


@given(st.floats(0.01, 50.0), st.floats(0.01, 5.0), st.none() | st.floats(0.1, 20.0))
def test_at_the_largest_speed_the_way_is_what_is_free(
    free_m: float, late_s: float, braking: float | None
) -> None:
    fastest = largest_speed_mps(free_m, late_s, braking)
    assert stopping_way_m(fastest, late_s, braking) == pytest.approx(free_m)


def test_a_body_as_large_as_it_sees_may_not_move() -> None:
    assert largest_speed_mps(0.0, 0.5, None) == 0.0
    with pytest.raises(ContractError, match="at most 0 m/s"):
        check_speed(contract(0.1, BodySpec(Footprint(radius_m=6.0))))


def test_a_sideways_speed_counts_with_the_one_ahead() -> None:
    assert not why_too_fast(contract(2.0, lateral_mps=1.9))
    assert why_too_fast(contract(2.0, lateral_mps=2.0))


def test_too_fast_is_refused_with_the_numbers_and_the_flag() -> None:
    with pytest.raises(ContractError) as refused:
        check_speed(contract(4.0))
    assert str(refused.value) == (
        "too fast for its eye: it drives 4 m/s and needs 7.6 m to stand (0.9 s late, brakes by "
        "2 m/s²), but sees 4.5 m from its edge: expected at most 2.81 m/s; --allow-fast if it is "
        "meant so"
    )
    assert check_speed(contract(4.0), allow=True) == ""
    assert check_speed(contract(1.0)) == ""


def test_a_contract_that_names_no_body_is_warned_of() -> None:
    """A point that stops at once: 5 m / 0.7 s = 7.14 m/s."""
    older = contract(8.0, BodySpec())
    assert "at most 7.14 m/s" in check_speed(older)
    assert check_speed(dataclasses.replace(older, max_input_age_s=0.2)) == ""
