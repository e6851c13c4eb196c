import math
from collections.abc import Callable

import numpy as np
import pytest

from reflexarc_baselines.history.flow.looming import NEVER_S, looming, tau_s
from reflexarc_baselines.history.flow.optic_flow import flow_contract
from reflexarc_runtime.arrays import RetinaBatch
from support.grating import bar, two_frames

EYE, DT_S, V_MPS = flow_contract().retina, 0.1, 1.0

Half = Callable[[float], float]


def face(away_m: float) -> float:
    """Half of the angle of a flat face 0.6 m wide."""
    return math.atan(0.3 / away_m)


def disc(away_m: float) -> float:
    """Half of the angle of a disc of radius 0.45 m, to its middle."""
    return math.asin(0.45 / away_m)


def seen(half: Half, away_m: float, shade: float = 0.8, background: float = 0.0) -> RetinaBatch:
    """Before and after a step that ends half a step past `away_m`."""
    before, now = (half(away_m + off * V_MPS * DT_S) for off in (0.5, -0.5))
    shown = [bar(angle, -angle, shade, background) for angle in (before, now)]
    return two_frames(*shown)


def exact_tau_s(half: Half, away_m: float) -> float:
    alphas = [2 * half(away_m + off * 1e-4) for off in (0.5, -0.5)]
    found = tau_s(np.array([alphas[1]]), np.array([alphas[0]]), 1e-4 / V_MPS)
    return float(found[0])


@pytest.mark.parametrize("away_m", [0.7, 1.5, 4.0])
def test_tau_of_a_flat_face_is_the_time_to_it(away_m: float) -> None:
    assert exact_tau_s(face, away_m) == pytest.approx(away_m / V_MPS, rel=1e-5)


@pytest.mark.parametrize("away_m", [0.7, 1.5, 4.0])
def test_tau_of_a_disc_is_short_of_its_middle_by_the_cosine_squared(away_m: float) -> None:
    """2 tan(α/2) / α̇ is the time to the middle; sin α is cos²(α/2) of 2 tan(α/2)."""
    expected_s = away_m / V_MPS * math.cos(disc(away_m)) ** 2
    assert exact_tau_s(disc, away_m) == pytest.approx(expected_s, rel=1e-5)


def test_alpha_itself_would_be_13_percent_too_long_at_48_degrees() -> None:
    assert math.radians(48) / math.sin(math.radians(48)) == pytest.approx(1.13, abs=0.005)


@pytest.mark.parametrize(("shade", "background"), [(0.8, 0.0), (0.1, 0.9), (1.0, 0.3)])
@pytest.mark.parametrize("away_m", [0.7, 1.0, 1.5])
def test_a_run_of_rays_tells_the_time_whether_it_is_bright_or_dark(
    away_m: float, shade: float, background: float
) -> None:
    run = looming(seen(face, away_m, shade, background), EYE, 0.6, DT_S)
    assert run.tau_s[0] == pytest.approx(away_m / V_MPS, rel=0.15)
    assert abs(run.bearing_rad[0]) < 1e-3


@pytest.mark.parametrize(("left_rad", "right_rad"), [(0.4, 0.1), (-0.1, -0.4)])
def test_it_knows_on_which_side_the_run_is(left_rad: float, right_rad: float) -> None:
    before = bar(left_rad - 0.01, right_rad + 0.01, 0.8, 0.0)
    run = looming(two_frames(before, bar(left_rad, right_rad, 0.8, 0.0)), EYE, 0.6, DT_S)
    assert run.bearing_rad[0] == pytest.approx((left_rad + right_rad) / 2, abs=0.03)
    assert run.tau_s[0] < NEVER_S


def test_what_stands_beside_a_gap_is_no_part_of_the_run() -> None:
    ahead, beside = seen(face, 1.0), bar(1.1, 0.9, 0.8, 0.0)
    both = np.maximum(ahead, two_frames(beside, beside))
    alone = looming(ahead, EYE, 0.6, DT_S)
    assert looming(both, EYE, 0.6, DT_S).tau_s[0] == alone.tau_s[0]
    assert looming(both, EYE, 0.6, DT_S).bearing_rad[0] == alone.bearing_rad[0]


def test_what_shrinks_or_stays_or_fills_the_eye_is_never_met() -> None:
    approaching = seen(face, 1.0)
    receding, still = approaching[:, ::-1], approaching[:, [1, 1]]
    wall = two_frames(np.full(16, 0.5), np.full(16, 0.7))
    aside = two_frames(bar(1.4, 1.1, 0.8, 0.0), bar(1.5, 1.0, 0.8, 0.0))
    for retinas in (receding, still, wall, aside):
        assert looming(retinas, EYE, 0.6, DT_S).tau_s.tolist() == [NEVER_S]
