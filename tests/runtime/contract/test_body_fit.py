import pytest

from reflexarc_runtime.contract.body_fit import check_body, shortfalls
from reflexarc_runtime.contract.body_spec import BodySpec, Footprint
from reflexarc_runtime.errors import ContractError

LEARNED = BodySpec(Footprint(radius_m=0.2), actuation_delay_s=0.1, deceleration_mps2=2.0)


def body(radius_m: float = 0.2, delay_s: float = 0.1, braking: float | None = 2.0) -> BodySpec:
    return BodySpec(Footprint(radius_m=radius_m), delay_s, braking)


@pytest.mark.parametrize(
    "true", [body(), body(0.1), body(0.0, 0.0, None), body(braking=5.0), body(delay_s=0.05)]
)
def test_the_same_body_and_any_better_one_fit(true: BodySpec) -> None:
    assert list(shortfalls(LEARNED, true)) == []
    check_body(LEARNED, true)


@pytest.mark.parametrize(
    ("true", "said"),
    [
        (body(radius_m=0.25), "it reaches 0.25 m, expected at most 0.2 m"),
        (body(braking=1.0), "it brakes by 1 m/s², expected at least 2 m/s²"),
        (body(delay_s=0.15), "it obeys after 0.15 s, expected at most 0.1 s"),
    ],
)
def test_a_larger_slower_or_later_body_is_refused(true: BodySpec, said: str) -> None:
    assert list(shortfalls(LEARNED, true)) == [said]
    with pytest.raises(ContractError, match=r"another body.*--allow-body") as refused:
        check_body(LEARNED, true)
    assert said in str(refused.value)
    check_body(LEARNED, true, allow=True)


def test_a_point_promises_nothing_of_a_body() -> None:
    said = list(shortfalls(BodySpec(), LEARNED))
    assert len(said) == 3
    assert "expected a stop at once" in said[1]


def test_of_a_rectangle_the_farthest_corner_counts() -> None:
    box = Footprint(ahead_m=0.3, behind_m=0.1, half_width_m=0.4)
    fits = BodySpec(Footprint(radius_m=0.5))
    assert list(shortfalls(fits, BodySpec(box))) == []
    assert list(shortfalls(BodySpec(Footprint(radius_m=0.49)), BodySpec(box)))
