import math

import numpy as np
import pytest

from reflexarc_baselines.history.flow.optic_flow import (
    balance,
    flow_contract,
    gradient_flow,
    outward,
    sides,
)
from reflexarc_runtime.contract.eye import RetinaSpec
from support.grating import bearings_rad, corridor, two_frames

EYE = flow_contract().retina


@pytest.mark.parametrize("omega_radps", [1.0, -1.5])
def test_a_sine_that_glides_past_gives_its_speed(omega_radps: float) -> None:
    """With m periods in 2π and ε = mωΔt: F = 2 tan(ε/2) / Δt · δφ / sin(m δφ), by hand."""
    m, dt_s, sector_rad = 3, 0.1, math.pi / 16
    now, before = (
        0.5 + 0.5 * np.sin(m * (bearings_rad(16) - omega_radps * t_s)) for t_s in (dt_s, 0.0)
    )
    flow = gradient_flow(two_frames(before, now), EYE, dt_s, 1e-6)[0, 1:-1]
    by_hand = (
        2 * math.tan(m * omega_radps * dt_s / 2) / dt_s * sector_rad / math.sin(m * sector_rad)
    )
    steep = np.abs(np.cos(m * bearings_rad(16)[1:-1])) > 0.5
    assert flow[steep] == pytest.approx(np.full(steep.sum(), by_hand), rel=0.06)


def test_without_slope_or_change_there_is_no_flow() -> None:
    bright, dark = np.ones(16), np.zeros(16)
    edge = np.where(np.arange(16) < 8, 0.2, 0.7)
    for before, now in ((dark, bright), (edge, edge)):
        assert not gradient_flow(two_frames(before, now), EYE, 0.1, 0.05).any()


def test_outward_is_counter_clockwise_on_the_left_and_clockwise_on_the_right() -> None:
    flow = np.array([[1.0, 2.0, -3.0, -5.0]], np.float32)
    assert outward(flow).tolist() == [[1.0, 2.0, 3.0, 5.0]]
    left, right = sides(outward(flow))
    assert (left[0], right[0]) == (1.5, 4.0)


@pytest.mark.parametrize(
    ("left", "right", "index"), [(3, 1, 0.5), (1, 3, -0.5), (0, 0, 0), (2, -1, 1), (-1, -2, 0)]
)
def test_balance_by_hand(left: float, right: float, index: float) -> None:
    found = balance(np.array([left], np.float32), np.array([right], np.float32))
    assert found.tolist() == pytest.approx([index], abs=1e-3)  # of sides that are not silent


def side_flows(aside_mps: float) -> tuple[float, float]:
    """Mean outward flow of both sides, 1 m from each wall, at 1 m/s and so much to the left."""
    eye, dt_s, period_m = RetinaSpec(rays=64, frames=2), 0.02, 2.0
    starts_m = np.arange(100) / 100 * period_m
    frames = [
        two_frames(
            corridor(x_m, 0.0, period_m, rays=64),
            corridor(x_m + dt_s, aside_mps * dt_s, period_m, rays=64),
        )
        for x_m in starts_m
    ]
    left, right = sides(outward(gradient_flow(np.concatenate(frames), eye, dt_s, 0.001)))
    return float(left.mean()), float(right.mean())


def test_a_wall_at_d_makes_a_mean_flow_of_v_by_2d() -> None:
    assert side_flows(0.0) == pytest.approx((0.5, 0.5), rel=0.05)


@pytest.mark.parametrize("aside_mps", [0.25, 1.0])
def test_a_sidestep_lessens_the_flow_of_its_side_by_2u_of_pi_v(aside_mps: float) -> None:
    straight, aside = side_flows(0.0), side_flows(aside_mps)
    share = 2.0 * aside_mps / math.pi
    assert aside[0] / straight[0] == pytest.approx(1.0 - share, abs=0.05)
    assert aside[1] / straight[1] == pytest.approx(1.0 + share, abs=0.05)
